//! Writes small ONNX networks, field by field in the form of a protocol buffer (onnx.proto, operators of version 13).

fn varint(mut n: u64) -> Vec<u8> {
    let mut out = Vec::new();
    while n >= 0x80 {
        out.push(n as u8 | 0x80);
        n >>= 7;
    }
    out.push(n as u8);
    out
}

fn number(field: u64, n: u64) -> Vec<u8> {
    [varint(field << 3), varint(n)].concat()
}

fn message(field: u64, parts: &[Vec<u8>]) -> Vec<u8> {
    let content = parts.concat();
    [varint(field << 3 | 2), varint(content.len() as u64), content].concat()
}

fn text(field: u64, text: &str) -> Vec<u8> {
    message(field, &[text.as_bytes().to_vec()])
}

fn node(inputs: &[&str], output: &str, operator: &str, attributes: &[Vec<u8>]) -> Vec<u8> {
    let inputs: Vec<Vec<u8>> = inputs.iter().map(|input| text(1, input)).collect();
    message(1, &[inputs, vec![text(2, output), text(3, output), text(4, operator)], attributes.to_vec()].concat())
}

/// An attribute with one whole number.
fn whole(name: &str, value: u64) -> Vec<u8> {
    message(5, &[text(1, name), number(3, value), number(20, 2)])
}

/// The description of a tensor of floats. A side whose length is free has a name instead of a number.
fn value(field: u64, name: &str, sides: &[Result<u64, &str>]) -> Vec<u8> {
    let sides: Vec<Vec<u8>> =
        sides.iter().map(|side| message(1, &[side.map_or_else(|name| text(2, name), |n| number(1, n))])).collect();
    message(field, &[text(1, name), message(2, &[message(1, &[number(1, 1), message(2, &sides)])])])
}

const PICTURE: [Result<u64, &str>; 4] = [Ok(1), Ok(3), Err("height"), Err("width")];

fn model(inputs: &[&str], nodes: &[Vec<u8>], metadata: &[(&str, &str)]) -> Vec<u8> {
    let inputs: Vec<Vec<u8>> = inputs.iter().map(|name| value(11, name, &PICTURE)).collect();
    let graph = [nodes.to_vec(), vec![text(2, "distance")], inputs, vec![value(12, "out", &[])]].concat();
    let entries = metadata.iter().map(|(key, value)| message(14, &[text(1, key), text(2, value)]));
    let head = vec![number(1, 7), message(8, &[text(1, ""), number(2, 13)]), message(7, &graph)];
    head.into_iter().chain(entries).collect::<Vec<_>>().concat()
}

fn nodes() -> Vec<Vec<u8>> {
    vec![
        node(&["reference", "picture"], "difference", "Sub", &[]),
        node(&["difference", "difference"], "square", "Mul", &[]),
        node(&["square"], "out", "ReduceMean", &[whole("keepdims", 0)]),
    ]
}

/// A network that computes the mean of the squared difference over pixels and channels.
pub fn mean_square() -> Vec<u8> {
    model(&["reference", "picture"], &nodes(), &[])
}

/// The same with the entry `smallest_side` in its metadata.
pub fn with_smallest_side(side: &str) -> Vec<u8> {
    model(&["reference", "picture"], &nodes(), &[("smallest_side", side)])
}

/// Files that are not valid networks of two pictures, each with a part of the message that refuses it.
pub fn broken_networks() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let whole = mean_square();
    let one = [node(&["reference", "reference"], "square", "Mul", &[]), nodes()[2].clone()];
    let no_number = [nodes()[0].clone(), node(&["difference"], "out", "Identity", &[])];
    let mean = || node(&["square"], "mean", "ReduceMean", &[self::whole("keepdims", 0)]);
    let after_the_mean = |last: Vec<u8>| [&nodes()[..2], &[mean(), last]].concat();
    let not_finite = after_the_mean(node(&["mean", "mean"], "out", "Div", &[]));
    let one_for_equal = after_the_mean(node(&["mean"], "out", "Exp", &[]));
    let unknown = [node(&["reference", "picture"], "out", "Perceive", &[])];
    vec![
        ("empty.onnx", Vec::new(), "not a network that compares two pictures"),
        ("text.onnx", b"these are no weights".to_vec(), "not a network that compares two pictures"),
        ("cut.onnx", whole[..whole.len() / 2].to_vec(), "not a network that compares two pictures"),
        ("one.onnx", model(&["reference"], &one, &[]), "it has 1 inputs instead of 2"),
        ("many.onnx", model(&["reference", "picture"], &no_number, &[]), "not a single number"),
        (
            "nan.onnx",
            model(&["reference", "picture"], &not_finite, &[]),
            "for two equal pictures it gives no finite number",
        ),
        (
            "one_for_equal.onnx",
            model(&["reference", "picture"], &one_for_equal, &[]),
            "for two equal pictures it gives 1, and not 0",
        ),
        ("unknown.onnx", model(&["reference", "picture"], &unknown, &[]), "Perceive"),
        ("side.onnx", with_smallest_side("many"), "smallest_side `many` is not a count"),
        ("zero.onnx", with_smallest_side("0"), "smallest_side `0` is not a count"),
    ]
}
