//! A ball in light that tells much of it.

/// A sky with waves, a lamp, and the ball.
pub const SCENE: &str = "void brightfunc wave 2 1+.8*sin(9*Dx)*sin(7*Dz+Dy) . 0 0\nwave glow sky 0 0 4 1 1.1 1.2 0\nsky source sky 0 0 4 0 0 1 360\n\
                         void light bulb 0 0 3 200 200 200\nbulb sphere lamp 0 0 4 -3 -4 4 .3\nit sphere s 0 0 4 0 0 0 1\n";
