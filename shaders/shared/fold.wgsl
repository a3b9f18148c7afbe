// Tissue that a folding joint displaces: what a group's raw distance loses beside the fold (prototypes 5).
override FOLD_SPREAD: f32;
override FOLD_LEAST_RADIUS: f32;

// Gradient of the offset in xyz, the offset itself in w; both in scene space at rest.
fn fold_lift(fold: Fold, p_rest: vec3<f32>) -> vec4<f32> {
    let from_centre = p_rest - fold.centre.xyz;
    let h = math_dot(from_centre, fold.axis.xyz);
    let half = select(fold.centre.w, fold.axis.w, h < 0.0);
    if fold.offset == 0.0 || abs(h) >= half {
        return vec4<f32>(0.0);
    }
    let out = from_centre - fold.axis.xyz * h;
    let radius = sqrt(math_dot(out, out));
    if radius < FOLD_LEAST_RADIUS {
        return vec4<f32>(0.0);
    }
    let x = h / half;
    let rest = 1.0 - x * x;
    let along = rest * rest;
    let direction = out / radius;
    let cosine = math_dot(direction, fold.inner.xyz);
    let t = clamp((cosine + 1.0) / FOLD_SPREAD, 0.0, 1.0);
    let around = 1.0 - fold.inner.w * (1.0 - math_smoothstep(t));
    let along_slope = -4.0 * rest * x / half;
    let around_slope = fold.inner.w * 6.0 * t * (1.0 - t) / FOLD_SPREAD;
    let turn = (fold.inner.xyz - direction * cosine) / radius;
    let gradient = (fold.axis.xyz * (around * along_slope) + turn * (along * around_slope)) * -fold.offset;
    return vec4<f32>(gradient, -fold.offset * (around * along));
}
