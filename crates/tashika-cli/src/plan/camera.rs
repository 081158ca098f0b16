//! Cameras of a scene that are chosen by name.

use tashika::scene::{Camera, Scene};

use crate::exit::Failure;

/// Name that stands for every camera, unless a camera has this name.
const ALL: &str = "all";

/// Names of cameras, as typed.
#[derive(Clone, Debug)]
pub struct Cameras(Vec<String>);

impl Cameras {
    /// Takes typed values, each one name or several with commas between; an empty list is the
    /// scene's first camera.
    pub fn new(typed: &[String]) -> Self {
        Self(typed.to_vec())
    }

    /// Returns true if several may be chosen, so that each image is named after its camera.
    pub fn several(&self) -> bool {
        self.0.len() > 1 || self.0.iter().any(|typed| typed == ALL || typed.contains(','))
    }

    /// Returns the names with commas between.
    pub fn typed(&self) -> String {
        self.0.join(",")
    }

    /// Chosen cameras of the scene, in the typed order, each once; at least one.
    pub fn of<'s>(&self, scene: &'s Scene) -> Result<Vec<&'s Camera>, Failure> {
        if self.0.is_empty() {
            return Ok(vec![&scene.cameras()[0]]);
        }
        let mut chosen: Vec<&'s Camera> = Vec::new();
        let mut choose = |camera: &'s Camera| {
            if !chosen.iter().any(|known| std::ptr::eq(*known, camera)) {
                chosen.push(camera);
            }
        };
        for typed in &self.0 {
            // A name may have a comma in it.
            if let Some(camera) = scene.camera(typed) {
                choose(camera);
            } else if typed == ALL {
                scene.cameras().iter().for_each(&mut choose);
            } else {
                for name in typed.split(',').map(str::trim) {
                    choose(scene.camera(name).ok_or_else(|| unknown(name, scene))?);
                }
            }
        }
        Ok(chosen)
    }
}

fn unknown(name: &str, scene: &Scene) -> Failure {
    let names: Vec<&str> = scene.cameras().iter().map(|c| c.name.as_str()).collect();
    Failure::option("camera", name, format!("one of the scene's: {}", names.join(", ")))
}

#[cfg(test)]
mod tests {
    use tashika::scene::builtin;

    use super::*;

    fn chosen(typed: &[&str], scene: &Scene) -> Result<Vec<String>, String> {
        let typed: Vec<String> = typed.iter().map(|&t| t.to_owned()).collect();
        let cameras = Cameras::new(&typed).of(scene).map_err(|e| e.to_string())?;
        Ok(cameras.into_iter().map(|c| c.name.clone()).collect())
    }

    #[test]
    fn cameras_are_chosen_by_name_in_lists_or_all() {
        let room = builtin::room();
        let names: Vec<String> = room.cameras().iter().map(|c| c.name.clone()).collect();
        let [first, second] = [names[0].as_str(), names[1].as_str()];
        assert_eq!(chosen(&[], &room).unwrap(), [first]);
        assert_eq!(chosen(&["all"], &room).unwrap(), names);
        let both = [second.to_owned(), first.to_owned()];
        assert_eq!(chosen(&[&format!("{second}, {first}")], &room).unwrap(), both);
        assert_eq!(chosen(&[second, first, second], &room).unwrap(), both);
        let said = chosen(&[&format!("{first},nobody")], &room).unwrap_err();
        assert!(said.contains("--camera = nobody") && said.contains(second), "{said}");
    }

    #[test]
    fn lists_and_all_may_be_several() {
        let several =
            |typed: &[&str]| Cameras::new(&typed.iter().map(|&t| t.to_owned()).collect::<Vec<_>>()).several();
        assert!(!several(&[]) && !several(&["top"]));
        assert!(several(&["top", "side"]) && several(&["top,side"]) && several(&["all"]));
    }
}
