//! Perlin's improved noise and sums of it.

use glam::DVec3;

/// The permutation of 0..256 that Perlin published with the reference implementation.
const PERMUTATION: [u8; 256] = [
    151, 160, 137, 91, 90, 15, 131, 13, 201, 95, 96, 53, 194, 233, 7, 225, 140, 36, 103, 30, 69,
    142, 8, 99, 37, 240, 21, 10, 23, 190, 6, 148, 247, 120, 234, 75, 0, 26, 197, 62, 94, 252, 219,
    203, 117, 35, 11, 32, 57, 177, 33, 88, 237, 149, 56, 87, 174, 20, 125, 136, 171, 168, 68, 175,
    74, 165, 71, 134, 139, 48, 27, 166, 77, 146, 158, 231, 83, 111, 229, 122, 60, 211, 133, 230,
    220, 105, 92, 41, 55, 46, 245, 40, 244, 102, 143, 54, 65, 25, 63, 161, 1, 216, 80, 73, 209, 76,
    132, 187, 208, 89, 18, 169, 200, 196, 135, 130, 116, 188, 159, 86, 164, 100, 109, 198, 173,
    186, 3, 64, 52, 217, 226, 250, 124, 123, 5, 202, 38, 147, 118, 126, 255, 82, 85, 212, 207, 206,
    59, 227, 47, 16, 58, 17, 182, 189, 28, 42, 223, 183, 170, 213, 119, 248, 152, 2, 44, 154, 163,
    70, 221, 153, 101, 155, 167, 43, 172, 9, 129, 22, 39, 253, 19, 98, 108, 110, 79, 113, 224, 232,
    178, 185, 112, 104, 218, 246, 97, 228, 251, 34, 242, 193, 238, 210, 144, 12, 191, 179, 162,
    241, 81, 51, 145, 235, 249, 14, 239, 107, 49, 192, 214, 31, 181, 199, 106, 157, 184, 84, 204,
    176, 115, 121, 50, 45, 127, 4, 150, 254, 138, 236, 205, 93, 222, 114, 67, 29, 24, 72, 243, 141,
    128, 195, 78, 66, 215, 61, 156, 180,
];

/// From the middle of a cube to its 12 edges; four of them come twice, so that 16 hashes have one each.
const GRADIENTS: [DVec3; 16] = [
    DVec3::new(1.0, 1.0, 0.0),
    DVec3::new(-1.0, 1.0, 0.0),
    DVec3::new(1.0, -1.0, 0.0),
    DVec3::new(-1.0, -1.0, 0.0),
    DVec3::new(1.0, 0.0, 1.0),
    DVec3::new(-1.0, 0.0, 1.0),
    DVec3::new(1.0, 0.0, -1.0),
    DVec3::new(-1.0, 0.0, -1.0),
    DVec3::new(0.0, 1.0, 1.0),
    DVec3::new(0.0, -1.0, 1.0),
    DVec3::new(0.0, 1.0, -1.0),
    DVec3::new(0.0, -1.0, -1.0),
    DVec3::new(1.0, 1.0, 0.0),
    DVec3::new(0.0, -1.0, 1.0),
    DVec3::new(-1.0, 1.0, 0.0),
    DVec3::new(0.0, -1.0, -1.0),
];

/// Improved noise (Perlin 2002, "Improving Noise"): 0 at every point with whole coordinates, about -1..=1 between
/// them, twice continuously differentiable, repeating every 256 along each axis.
pub fn noise(p: DVec3) -> f64 {
    let floor = p.floor();
    let q = p - floor;
    // Exact at any distance from the origin, where a whole number may not fit an integer.
    let cell = (floor - 256.0 * (floor / 256.0).floor()).as_uvec3();
    let permute = |i: u32| u32::from(PERMUTATION[(i & 255) as usize]);
    // Hashes of the corners by z, y and x.
    let mut hashes = [[[0; 2]; 2]; 2];
    for x in 0..2 {
        let column = permute(cell.x + x) + cell.y;
        for y in 0..2 {
            let row = permute(column + y) + cell.z;
            for z in 0..2 {
                hashes[z as usize][y as usize][x as usize] = permute(row + z) & 15;
            }
        }
    }
    let corner = |x: usize, y: usize, z: usize| {
        let offset = DVec3::new(x as f64, y as f64, z as f64);
        GRADIENTS[hashes[z][y][x] as usize].dot(q - offset)
    };
    let blend = q * q * q * (q * (6.0 * q - 15.0) + 10.0);
    let lerp = |t: f64, a: f64, b: f64| a + t * (b - a);
    let along_x = |y, z| lerp(blend.x, corner(0, y, z), corner(1, y, z));
    let along_y = |z| lerp(blend.y, along_x(0, z), along_x(1, z));
    lerp(blend.z, along_y(0), along_y(1))
}

/// Fractional Brownian motion: each of the octaves has half the size and half the height of the one before.
pub fn fbm(p: DVec3, octaves: u32) -> f64 {
    octaves_of(octaves, |frequency| noise(frequency * p))
}

/// As [`fbm`], of the noise's absolute value, which has creases where the noise is 0 (Perlin 1985, "An Image
/// Synthesizer").
pub fn turbulence(p: DVec3, octaves: u32) -> f64 {
    octaves_of(octaves, |frequency| noise(frequency * p).abs())
}

fn octaves_of(octaves: u32, value: impl Fn(f64) -> f64) -> f64 {
    let frequencies = (0..octaves as i32).map(|octave| 2.0_f64.powi(octave));
    frequencies.map(|f| value(f) / f).sum()
}

/// Absolute noise at all multiples of one frequency, level by level, up to `levels`: the sum of
/// `|noise(0.05 level p)| / level`.
pub fn harmonics(p: DVec3, levels: u32) -> f64 {
    let levels = (1..=levels).map(f64::from);
    levels.map(|l| noise(0.05 * l * p).abs() / l).sum()
}
