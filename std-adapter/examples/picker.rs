//! A picker: what is under the mouse, what a frame drawn with it holds, and what is nearest, asked of the boxes as they are, without a
//! step. And a sensor, which is a box like others: who enters it is told by the pairs that a step has found.

use trisap::{Aabb, BroadPhase, Cast, Error, Region};

type Town = BroadPhase<&'static str>;

/// A town of houses, and one that flies.
fn town() -> Result<Town, Error> {
    let mut town = Town::new();
    town.insert("ground", Aabb::new([-100.0, -100.0, -1.0], [100.0, 100.0, 0.0]))?;
    town.insert("church", Aabb::new([0.0, 0.0, 0.0], [10.0, 20.0, 40.0]))?;
    town.insert("inn", Aabb::new([20.0, 0.0, 0.0], [30.0, 8.0, 9.0]))?;
    town.insert("balloon", Aabb::from_center([25.0, 4.0, 60.0], [6.0; 3]))?;
    town.step()?;
    Ok(town)
}

/// The ray through a point of a screen of 100 by 100, from an eye above the town.
fn ray(x: f32, y: f32) -> Cast {
    Cast::ray([25.0, 4.0, 100.0], [(x - 50.0) / 50.0, (y - 50.0) / 50.0, -1.0], f32::INFINITY)
}

/// What is seen there.
fn under(town: &Town, x: f32, y: f32) -> Result<Option<&'static str>, Error> {
    Ok(town.first_hit(&ray(x, y))?.map(|(house, _)| house))
}

fn main() -> Result<(), Error> {
    let mut town = town()?;
    assert_eq!(under(&town, 50.0, 50.0)?, Some("balloon"));
    assert_eq!(under(&town, 33.0, 50.0)?, Some("church"));
    assert_eq!(under(&town, 50.0, 70.0)?, Some("ground"));
    // What flies can be hidden.
    let standing = town.among(|house| house != "balloon").first_hit(&ray(50.0, 50.0))?;
    assert_eq!(standing, Some(("inn", 91.0)));
    // The balloon is dragged away: what is below is seen without a step.
    town.insert("balloon", Aabb::from_center([-60.0, 4.0, 60.0], [6.0; 3]))?;
    assert_eq!(under(&town, 50.0, 50.0)?, Some("inn"));

    let mut framed = town.overlaps(&Region::Aabb(Aabb::new([-1.0, -1.0, 1.0], [40.0, 40.0, 50.0])))?;
    framed.sort_unstable();
    assert_eq!(framed, ["church", "inn"]);
    let nearest = town.nearest([20.5, 4.0, 12.0], 2)?;
    assert_eq!(nearest, [("inn", 3.0), ("church", 10.5)]);

    town.insert("doorstep of the inn", Aabb::new([18.0, 3.0, 0.5], [19.5, 5.0, 2.5]))?;
    assert_eq!(town.step()?.found().count(), 0);
    town.insert("guest", Aabb::from_center([17.8, 4.0, 1.4], [0.3, 0.3, 0.9]))?;
    assert_eq!(town.step()?.found().collect::<Vec<_>>(), [["doorstep of the inn", "guest"]]);
    town.insert("guest", Aabb::from_center([12.0, 4.0, 1.4], [0.3, 0.3, 0.9]))?;
    assert_eq!(town.step()?.lost().collect::<Vec<_>>(), [["doorstep of the inn", "guest"]]);
    println!("under the mouse: the inn; in the frame: {framed:?}; nearest: {nearest:?}");
    Ok(())
}

#[test]
fn what_is_under_the_mouse_is_picked() {
    main().unwrap();
}
