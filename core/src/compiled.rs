//! The large functions of a world, compiled with this crate for both widths of slots. A program links generic code that an upstream
//! crate has compiled and that is never inlined; else each program and each test compiles all of the core anew. In builds with debug
//! assertions alone, as these are made again and again; in others whatever gains by it is inlined.

use crate::id::Index;
use crate::world::World;
use core::hint::black_box;

/// What keeps them.
#[used]
static COMPILED: [fn(); 2] = [mentioned::<u16>, mentioned::<u32>];

fn mentioned<I: Index>() {
    black_box((
        World::<I>::new_in as fn(_, _) -> _,
        World::<I>::open as fn(_) -> _,
        World::<I>::insert as fn(_, _) -> _,
        World::<I>::set_margin as fn(_, _, _) -> _,
        World::<I>::update_many as fn(_, _, _) -> _,
        World::<I>::remove_many as fn(_, _) -> _,
        World::<I>::set_resting as fn(_, _) -> _,
        World::<I>::step as fn(_) -> _,
        World::<I>::shift_origin as fn(_, _) -> _,
    ));
    black_box((
        World::<I>::visit_overlaps as fn(_, _, _) -> _,
        World::<I>::visit_hits as fn(_, _, _) -> _,
        World::<I>::visit_nearest as fn(_, _, _, _) -> _,
        World::<I>::nearest as fn(_, _, _) -> _,
        World::<I>::first_hits as fn(_, _, _, _) -> _,
        World::<I>::overlaps_many as fn(_, _, _, _, _) -> _,
        World::<I>::save as fn(_, _) -> _,
        World::<I>::load as fn(_, _) -> _,
        World::<I>::move_into as fn(_, _, _) -> _,
        World::<I>::validate as fn(_) -> _,
    ));
}
