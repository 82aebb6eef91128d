//! What single pixels tell is not certain: the values follow them, so that nothing is left over there that would show an error.

use crate::photograph::photographed;
use crate::photograph::said::{recovered, said};
use crate::photograph::waves::SCENE;

#[test]
fn a_highlight_smaller_than_a_pixel_tells_a_roughness() {
    // Of eight pictures and searches of .01 all were within two errors, of .0007 to .011, and of ten of .02, of .001 to .0092.
    for truth in [0.02, 0.01] {
        let material = format!("plastic it 0 0 5 .12 .79 .68 .07 {truth}");
        let directory = photographed(&material, SCENE, "-x 40 -y 40 --spp 256 --seed 7 -ab 1 -o target.exr");
        let out = recovered(directory.path(), "-ab 1 --seed 2 --scene scene.rad --target target.exr start.rad");
        let (value, error) = said(&out, "rough");
        assert!(!out.contains("# warning: rough is not determined: ") && error < 0.06, "{value} ± {error}");
        assert!((value - truth).abs() < 3.0 * error, "{value} ± {error}, not {truth}");
    }
}
