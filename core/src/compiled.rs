//! Compiles the large functions of a world with this crate, for both widths of slots, in builds with debug
//! assertions. A program then links them; else each program and each test would compile all of the core anew. Other
//! builds inline them where it pays.

use crate::id::Index;
use crate::world::World;
use core::hint::black_box;

/// Keeps them in the crate.
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
