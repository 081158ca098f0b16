//! Elements of `<transform>` and of `<animation>`, and attributes that are numbers.
//!
//! The steps are `translate`, `scale`, `rotate`, `matrix` and `lookat`; vectors are given as
//! `value`, or as `x`, `y`, `z`. The matrices of the steps are in [`transforms`]. Held to this by
//! `suite::mitsuba`, `suite::damaged_mitsuba`.

use glam::DMat4;
use roxmltree::Node;

use super::object::Value;
use super::reader::{MAX_NESTING, Reader, Source};
use super::transforms;
use super::values;
use crate::error::{Error, Location, Result, nearest_name};
use crate::io::notes::shown;
use crate::math::motion::Track;
use crate::scene::NoteKind;

impl Reader<'_> {
    pub(super) fn transform(
        &mut self,
        node: Node<'_, '_>,
        source: &Source<'_>,
        depth: usize,
        at: &Location,
    ) -> Result<DMat4> {
        let mut matrix = DMat4::IDENTITY;
        if depth + 1 > MAX_NESTING {
            return Ok(matrix);
        }
        for step in node.children().filter(Node::is_element) {
            let at = source.at(step.range().start);
            if let Some(m) = self.step(step, &at)? {
                matrix = m * matrix;
            }
        }
        if transforms::is_affine(&matrix) {
            return Ok(matrix);
        }
        Err(Error::invalid(
            at.clone(),
            format!("a transform with the matrix {:?}", matrix.transpose().to_cols_array()),
            "finite numbers of sensible size, and 0 0 0 1 in the last row",
        ))
    }

    /// Reads the keys of an `<animation>`, each a transform at a `time` (s).
    pub(super) fn animation(
        &mut self,
        node: Node<'_, '_>,
        source: &Source<'_>,
        depth: usize,
        at: &Location,
    ) -> Result<Option<Value>> {
        let options = self.files.options();
        let (asked, exposure) = (options.time(), options.exposure(None));
        if asked.is_none() {
            self.document.stopped.push(at.clone());
        }
        let (mut first, mut keys) = (None, Vec::new());
        for key in node.children().filter(Node::is_element) {
            let at = source.at(key.range().start);
            let map = self.transform(key, source, depth, &at)?;
            first = first.or(Some(map));
            match self.number(key, "time", &at)? {
                Some(seconds) => keys.push((seconds, transforms::affine_f64(&map))),
                None => {
                    self.notes.push(NoteKind::Repaired, "keys of animations without a time: left out", at)
                }
            }
        }
        let Some(first) = first else { return Ok(None) };
        let timed = !keys.is_empty();
        let Some(track) = Track::new(keys) else {
            if timed {
                let message = "animations with a key that cannot be inverted: the first key is shown";
                self.notes.push(NoteKind::Repaired, message, at.clone());
            }
            return Ok(Some(Value::Transform(first)));
        };
        self.document.animated.push(track.span());
        if exposure.is_some_and(|shutter| track.moves_between(shutter)) {
            self.document.stopped.push(at.clone());
        }
        let now = asked.map_or(first, |seconds| DMat4::from(track.at(seconds)));
        Ok(Some(Value::Animation(track, now)))
    }

    fn step(&mut self, node: Node<'_, '_>, at: &Location) -> Result<Option<DMat4>> {
        let tag = node.tag_name().name();
        let invalid = |found: String, expected: &str| Error::invalid(at.clone(), found, expected);
        Ok(Some(match tag.to_ascii_lowercase().as_str() {
            "translate" => DMat4::from_translation(self.coordinates(node, 0.0, at)?.into()),
            "scale" => DMat4::from_scale(self.coordinates(node, 1.0, at)?.into()),
            "rotate" => {
                let axis = self.coordinates(node, 0.0, at)?;
                let angle = self.number(node, "angle", at)?.unwrap_or(0.0);
                let Some(rotation) = transforms::rotation(axis.into(), angle) else {
                    self.notes.push(NoteKind::Repaired, "rotations without axis: left out", at.clone());
                    return Ok(None);
                };
                rotation
            }
            "matrix" => {
                let Some(text) = self.attribute(node, "value", at)? else { return Ok(None) };
                let rows = values::numbers(&text).and_then(|rows| transforms::matrix(&rows));
                rows.ok_or_else(|| invalid(format!("matrix {:?}", shown(&text)), "16 or 9 finite numbers"))?
            }
            "lookat" => {
                let origin = self.point(node, ["origin", "ox", "oy", "oz"], [0.0; 3], at)?;
                let target = self.point(node, ["target", "tx", "ty", "tz"], [0.0, 0.0, 1.0], at)?;
                let up = self.point(node, ["up", "ux", "uy", "uz"], [0.0, 1.0, 0.0], at)?;
                let looking = transforms::look_at(origin.into(), target.into(), up.into());
                let Some((matrix, replaced)) = looking else {
                    self.notes.push(NoteKind::Repaired, "lookat without direction: left out", at.clone());
                    return Ok(None);
                };
                if replaced {
                    let message = "lookat with up along the view: another direction is up";
                    self.notes.push(NoteKind::Repaired, message, at.clone());
                }
                matrix
            }
            _ => {
                if let Some(near) = nearest_name(tag, ["translate", "scale", "rotate", "matrix", "lookat"]) {
                    return Err(Error::misspelt(at.clone(), "transform step", &shown(tag), near));
                }
                let message = format!("transform step <{}> is unknown: left out", shown(tag));
                self.notes.push(NoteKind::Ignored, message, at.clone());
                return Ok(None);
            }
        }))
    }

    /// `value` (one or three numbers), or `x`, `y`, `z`.
    pub(super) fn coordinates(
        &mut self,
        node: Node<'_, '_>,
        missing: f64,
        at: &Location,
    ) -> Result<[f64; 3]> {
        if let Some(text) = self.attribute(node, "value", at)? {
            return Ok(self.vector(&text, at)?.into());
        }
        let mut all = [missing; 3];
        for (v, name) in all.iter_mut().zip(["x", "y", "z"]) {
            *v = self.number(node, name, at)?.unwrap_or(*v);
        }
        Ok(all)
    }

    /// An attribute of three numbers, or three attributes.
    fn point(
        &mut self,
        node: Node<'_, '_>,
        names: [&str; 4],
        missing: [f64; 3],
        at: &Location,
    ) -> Result<[f64; 3]> {
        if let Some(text) = self.attribute(node, names[0], at)? {
            return Ok(self.vector(&text, at)?.into());
        }
        let mut all = missing;
        for (v, name) in all.iter_mut().zip(&names[1..]) {
            *v = self.number(node, name, at)?.unwrap_or(*v);
        }
        Ok(all)
    }

    fn vector(&self, text: &str, at: &Location) -> Result<glam::DVec3> {
        let invalid =
            || Error::invalid(at.clone(), format!("{:?}", shown(text)), "one or three finite numbers");
        values::vector(text).ok_or_else(invalid)
    }

    pub(super) fn number(&mut self, node: Node<'_, '_>, name: &str, at: &Location) -> Result<Option<f64>> {
        let Some(text) = self.attribute(node, name, at)? else { return Ok(None) };
        // Temperatures are sometimes written with their unit.
        let number = text.trim().trim_end_matches(['K', 'k']);
        let invalid =
            || Error::invalid(at.clone(), format!("{name} = {:?}", shown(&text)), "a finite number");
        values::number(number).map(Some).ok_or_else(invalid)
    }
}
