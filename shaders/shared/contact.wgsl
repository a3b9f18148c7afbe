// What a vertex tracks: the composed field, and at a contact its own side of it (prototypes 3). Reads groups, nodes,
// muscles and axes. The derivative of the weight w is left out, as in the authors' operators.
override CONTACT_AGREE: f32;
override CONTACT_TURN: f32;

fn contact_own_side(place: FieldPlace, owner: u32, limit: f32, p_posed: vec3<f32>) -> GroupSample {
    var own = Sample(0.0, vec3<f32>(0.0));
    var other = GroupSample(0.0, vec3<f32>(0.0), FIELD_NO_GROUP);
    for (var g = 0u; g < place.group_count; g++) {
        if groups[place.group + g].present == 0u {
            continue;
        }
        let sample = field_group(groups[place.group + g], place, p_posed);
        if g == owner {
            own = sample;
        } else if sample.value > other.value {
            other = GroupSample(sample.value, sample.gradient, g);
        }
    }
    var largest = GroupSample(own.value, own.gradient, owner);
    if other.value > own.value {
        largest = other;
    }
    let product = math_dot(own.gradient, own.gradient) * math_dot(other.gradient, other.gradient);
    if product <= 0.0 {
        return largest;
    }
    let cosine = math_dot(own.gradient, other.gradient) / sqrt(product);
    let t = clamp((CONTACT_AGREE - cosine) / CONTACT_TURN, 0.0, 1.0);
    let w = t * t * (3.0 - 2.0 * t);
    var value = (1.0 - w) * largest.value + w * own.value;
    var gradient = largest.gradient * (1.0 - w) + own.gradient * w;
    if other.value > limit {
        value -= w * (other.value - limit);
        gradient -= other.gradient * w;
    }
    return GroupSample(value, gradient, largest.group);
}
