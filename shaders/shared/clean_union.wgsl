// The clean union of two fields (background 3.3).

override CLEAN_SURFACE: f32;
override CLEAN_SMALL: f32;
override CLEAN_ITERATIONS: u32;

// Value, derivative by the larger, derivative by the smaller of two values.
fn clean_values(big: f32, small: f32) -> vec3<f32> {
    let below = big < CLEAN_SURFACE;
    if select(small * small <= CLEAN_SURFACE * big, small <= 2.0 * big * big, below) {
        return vec3<f32>(big, 1.0, 0.0);
    }
    var unit: f32;
    var ratio: f32;
    var x: f32;
    var u1 = 0.0;
    var u2 = 0.0;
    var w2: f32;
    if big < CLEAN_SMALL {
        unit = big;
        ratio = small / big;
        u2 = 2.0 * unit;
        w2 = -2.0 * unit;
        x = sqrt(1.0 + ratio * ratio) / (1.0 + unit * ratio);
    } else if below {
        unit = CLEAN_SURFACE - big;
        ratio = (CLEAN_SURFACE - small) / unit;
        u1 = 2.0;
        u2 = -2.0 * unit;
        w2 = -2.0 * unit;
        x = (2.0 * (1.0 + ratio) + sqrt(max(8.0 * ratio - 3.0 - 3.0 * ratio * ratio, 0.0))) / 7.0;
        x = min(x, 1.0);
    } else {
        unit = big - CLEAN_SURFACE;
        ratio = (small - CLEAN_SURFACE) / unit;
        u1 = 1.0;
        w2 = 2.0 * unit;
        x = 1.0 + ratio - sqrt(2.0 * ratio);
    }
    for (var i = 0u; i < CLEAN_ITERATIONS; i++) {
        let u = x * (u1 + u2 * x);
        let w = x + w2 * x * x;
        let p = u - 1.0;
        let r = u - ratio;
        let slope = (p + r) * (u1 + 2.0 * u2 * x) - w * (1.0 + 2.0 * w2 * x);
        x -= (p * p + r * r - w * w) / (2.0 * slope);
    }
    let u = x * (u1 + u2 * x);
    let w = x + w2 * x * x;
    let p = abs(u - 1.0);
    let r = abs(u - ratio);
    let offset = unit * x;
    var value: f32;
    var k_slope: f32;
    if below {
        value = select(CLEAN_SURFACE - offset, offset, big < CLEAN_SMALL);
        k_slope = 4.0 * value;
    } else {
        value = CLEAN_SURFACE + 2.0 * offset * (1.0 + offset);
        if value >= 1.0 {
            return vec3<f32>(1.0, 0.0, 0.0);
        }
        k_slope = 0.25 / (CLEAN_SURFACE + offset);
    }
    let scale = 1.0 / (k_slope * (p + r) + (1.0 - k_slope) * w);
    return vec3<f32>(max(value, big), p * scale, r * scale);
}

fn clean_union(a: Sample, b: Sample) -> Sample {
    if b.value > a.value {
        let found = clean_values(b.value, a.value);
        return Sample(found.x, b.gradient * found.y + a.gradient * found.z);
    }
    let found = clean_values(a.value, b.value);
    return Sample(found.x, a.gradient * found.y + b.gradient * found.z);
}
