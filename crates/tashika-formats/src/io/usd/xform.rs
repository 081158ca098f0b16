//! Transforms: the stack of a prim's operations.
//!
//! With `M_i` the matrix of the `i`-th name in `xformOpOrder`, acting on columns,
//!
//! ```text
//! M = M_1 M_2 … M_n
//! ```
//!
//! so that the last operation acts on points first. Matrices in files act on row vectors and are
//! therefore transposed. `rotateXYZ` turns around `x` first: `R_z R_y R_x`. Angles are in degrees.
//!
//! Held to this by the tests below, `usd_meshes::operations_multiply_in_their_order` and
//! `usd::composed_scenes_are_what_pixars_library_reads`.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::Stage;
use super::prim::Prim;
use super::value::Value;
use crate::error::{Error, Result};
use crate::io::notes::quoted;
use crate::math::elementary::sin_cos_f64;
use crate::scene::NoteKind;

/// Largest number of operations of a prim.
const MAX_OPS: usize = 1000;

/// A prim's transform.
pub(super) struct Local {
    /// Transform from the prim to its parent.
    pub to_parent: DAffine3,
    /// True if the transforms of the prims above do not apply.
    pub resets: bool,
}

impl Stage<'_> {
    /// The transform of a prim.
    pub fn local(&mut self, prim: &Prim) -> Result<Local> {
        let mut local = Local { to_parent: DAffine3::IDENTITY, resets: false };
        let Some(order) = self.value(prim, "xformOpOrder")? else { return Ok(local) };
        for name in order.texts().unwrap_or_default().iter().take(MAX_OPS) {
            if &**name == "!resetXformStack!" {
                local = Local { to_parent: DAffine3::IDENTITY, resets: true };
                continue;
            }
            let (attribute, is_inverse) = match name.strip_prefix("!invert!") {
                Some(attribute) => (attribute, true),
                None => (&**name, false),
            };
            let Some(value) = self.value(prim, attribute)? else { continue };
            let kind = attribute.split(':').nth(1).unwrap_or_default();
            let Some(op) = operation(kind, &value) else {
                let found = format!("{} of {value:.60?}", quoted(attribute));
                let at = self.at_property(prim, attribute);
                return Err(Error::invalid(at, found, "an operation with finite numbers as its kind wants"));
            };
            if kind == "transform" && !is_affine(&value) {
                let at = self.at_property(prim, attribute);
                self.builder.note(
                    NoteKind::Repaired,
                    "matrices whose last column is not 0 0 0 1: taken as if it were",
                    at,
                );
            }
            if is_inverse && op.matrix3.determinant() == 0.0 {
                let at = self.at_property(prim, attribute);
                let message = "inverses of transforms that have none: what they move is left out";
                self.builder.note(NoteKind::Repaired, message, at);
                local.to_parent *= DAffine3::from_scale(DVec3::ZERO);
                continue;
            }
            local.to_parent *= if is_inverse { op.inverse() } else { op };
        }
        Ok(local)
    }
}

/// Transform of an operation; none if its value has the wrong type.
fn operation(kind: &str, value: &Value) -> Option<DAffine3> {
    let vector = || value.tuple::<3>().map(DVec3::from_array);
    let along = |axis: DVec3, rest: f64| value.number().map(|n| axis * n + (DVec3::ONE - axis) * rest);
    let op = match kind {
        "translate" => DAffine3::from_translation(vector()?),
        "translateX" => DAffine3::from_translation(along(DVec3::X, 0.0)?),
        "translateY" => DAffine3::from_translation(along(DVec3::Y, 0.0)?),
        "translateZ" => DAffine3::from_translation(along(DVec3::Z, 0.0)?),
        "scale" => DAffine3::from_scale(vector()?),
        "scaleX" => DAffine3::from_scale(along(DVec3::X, 1.0)?),
        "scaleY" => DAffine3::from_scale(along(DVec3::Y, 1.0)?),
        "scaleZ" => DAffine3::from_scale(along(DVec3::Z, 1.0)?),
        "orient" => {
            let [w, x, y, z] = value.tuple::<4>()?;
            let quaternion = DQuat::from_xyzw(x, y, z, w);
            let length = quaternion.length();
            if !(length.is_finite() && length > 1e-12) {
                return None;
            }
            DAffine3::from_quat(quaternion / length)
        }
        "transform" => {
            let m = value.tuple::<16>()?;
            let row = |i: usize| DVec3::new(m[i], m[i + 1], m[i + 2]);
            DAffine3 { matrix3: DMat3::from_cols(row(0), row(4), row(8)), translation: row(12) }
        }
        turn => {
            let axes = turn.strip_prefix("rotate")?;
            let angles = match (axes.len(), value.number()) {
                (1, Some(angle)) => [angle; 3],
                (3, None) => value.tuple::<3>()?,
                _ => return None,
            };
            let mut all = DMat3::IDENTITY;
            for axis in axes.bytes() {
                let i = usize::from(axis.checked_sub(b'X').filter(|i| *i < 3)?);
                all = rotation(i, angles[i]) * all;
            }
            DAffine3::from_mat3(all)
        }
    };
    op.is_finite().then_some(op)
}

/// Rotation around an axis; quarter turns are exact.
fn rotation(axis: usize, degrees: f64) -> DMat3 {
    let turn = degrees.rem_euclid(360.0);
    let (sin, cos) = if turn % 90.0 == 0.0 {
        [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][(turn / 90.0) as usize % 4]
    } else {
        sin_cos_f64(turn.to_radians())
    };
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut columns = [[0.0; 3]; 3];
    columns[axis][axis] = 1.0;
    columns[next][next] = cos;
    columns[next][last] = sin;
    columns[last][last] = cos;
    columns[last][next] = -sin;
    DMat3::from_cols_array_2d(&columns)
}

fn is_affine(value: &Value) -> bool {
    value.tuple::<16>().is_none_or(|m| [m[3], m[7], m[11], m[15]] == [0.0, 0.0, 0.0, 1.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moved(kind: &str, numbers: &[f64], p: [f64; 3]) -> DVec3 {
        let value = match numbers {
            [one] => Value::Number(*one),
            all => Value::Tuple(all.to_vec()),
        };
        operation(kind, &value).unwrap().transform_point3(DVec3::from_array(p))
    }

    #[test]
    fn operations_act_as_their_names_say() {
        let near = |a: DVec3, b: [f64; 3]| assert!((a - DVec3::from_array(b)).length() < 1e-12, "{a} {b:?}");
        near(moved("rotateX", &[90.0], [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        near(moved("rotateY", &[90.0], [0.0, 0.0, 1.0]), [1.0, 0.0, 0.0]);
        near(moved("rotateZ", &[90.0], [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        // Around x first, then y: y goes to z, then to x.
        near(moved("rotateXYZ", &[90.0, 90.0, 0.0], [0.0, 1.0, 0.0]), [1.0, 0.0, 0.0]);
        // First around y, which does not change the y axis, then around x.
        near(moved("rotateYXZ", &[90.0, 90.0, 0.0], [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        near(moved("scaleY", &[3.0], [1.0, 1.0, 1.0]), [1.0, 3.0, 1.0]);
        near(moved("translateZ", &[3.0], [1.0, 1.0, 1.0]), [1.0, 1.0, 4.0]);
        // Half a turn around z, as a quaternion of length 2 with its real part first.
        near(moved("orient", &[0.0, 0.0, 0.0, 2.0], [1.0, 0.0, 0.0]), [-1.0, 0.0, 0.0]);
        // Rows of a matrix that maps x to y and y to −x, and then translates along x.
        let rows = [0.0, 1.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 5.0, 0.0, 0.0, 1.0];
        near(moved("transform", &rows, [1.0, 0.0, 0.0]), [5.0, 1.0, 0.0]);
        assert!(operation("rotateXYZ", &Value::Number(1.0)).is_none());
        assert!(operation("spin", &Value::Number(1.0)).is_none());
        assert!(operation("translate", &Value::Tuple(vec![f64::NAN; 3])).is_none());
    }
}
