/// Weight of a sample drawn with density `pdf` where another strategy would draw it with `other`
/// (Veach 1997, section 9.2.4, the power heuristic with exponent 2). An infinite `pdf` is a delta lobe,
/// which no other strategy can sample: its weight is 1.
pub fn power_heuristic(pdf: f32, other: f32) -> f32 {
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}
