//! Operations of a graph.

use crate::scalar::Scalar;

/// The index of a node in a list of nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(pub(crate) u32);

impl NodeId {
    /// The index, from 0.
    #[doc(hidden)]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl From<usize> for NodeId {
    fn from(index: usize) -> Self {
        Self(u32::try_from(index).expect("a graph of less than 2³² nodes"))
    }
}

/// Operation of a node, with operands of type `I`: nodes of a graph, or their replacements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Operation<I = NodeId> {
    /// A constant, by its bits.
    Constant(u64),
    /// An entry of the inputs, counted over all of them.
    Input(u32),
    /// −a
    Neg(I),
    /// a + b
    Add(I, I),
    /// a − b
    Sub(I, I),
    /// a b
    Mul(I, I),
    /// a / b
    Div(I, I),
    /// a b + c, rounded once if the target has such an instruction
    MulAdd(I, I, I),
    /// a b − c, likewise
    MulSub(I, I, I),
    /// c − a b, likewise
    NegMulAdd(I, I, I),
    /// √a
    Sqrt(I),
    /// sin a
    Sin(I),
    /// cos a
    Cos(I),
    /// eᵃ
    Exp(I),
    /// ln a
    Ln(I),
    /// The angle of the point (b, a).
    Atan2(I, I),
    /// asin a
    Asin(I),
    /// acos a
    Acos(I),
    /// tanh a
    Tanh(I),
    /// The third operand if the first is less than the second, otherwise the fourth.
    SelectLt(I, I, I, I),
}

/// Largest number of operands of an operation.
const OPERANDS: usize = 4;

impl<I: Copy> Operation<I> {
    /// The operands, in order.
    #[doc(hidden)]
    pub fn operands(&self) -> impl Iterator<Item = I> + use<I> {
        use Operation::{
            Acos, Add, Asin, Atan2, Constant, Cos, Div, Exp, Input, Ln, Mul, MulAdd, MulSub, Neg,
            NegMulAdd, SelectLt, Sin, Sqrt, Sub, Tanh,
        };
        let all: [Option<I>; OPERANDS] = match *self {
            Constant(_) | Input(_) => [None; OPERANDS],
            Neg(a) | Sqrt(a) | Sin(a) | Cos(a) | Exp(a) | Ln(a) | Asin(a) | Acos(a) | Tanh(a) => {
                [Some(a), None, None, None]
            }
            Add(a, b) | Sub(a, b) | Mul(a, b) | Div(a, b) | Atan2(a, b) => {
                [Some(a), Some(b), None, None]
            }
            MulAdd(a, b, c) | MulSub(a, b, c) | NegMulAdd(a, b, c) => {
                [Some(a), Some(b), Some(c), None]
            }
            SelectLt(a, b, x, y) => [Some(a), Some(b), Some(x), Some(y)],
        };
        all.into_iter().flatten()
    }

    /// Copies the operation onto other operands.
    pub(crate) fn map<J>(&self, mut to: impl FnMut(I) -> J) -> Operation<J> {
        match *self {
            Self::Constant(bits) => Operation::Constant(bits),
            Self::Input(i) => Operation::Input(i),
            Self::Neg(a) => Operation::Neg(to(a)),
            Self::Add(a, b) => Operation::Add(to(a), to(b)),
            Self::Sub(a, b) => Operation::Sub(to(a), to(b)),
            Self::Mul(a, b) => Operation::Mul(to(a), to(b)),
            Self::Div(a, b) => Operation::Div(to(a), to(b)),
            Self::MulAdd(a, b, c) => Operation::MulAdd(to(a), to(b), to(c)),
            Self::MulSub(a, b, c) => Operation::MulSub(to(a), to(b), to(c)),
            Self::NegMulAdd(a, b, c) => Operation::NegMulAdd(to(a), to(b), to(c)),
            Self::Sqrt(a) => Operation::Sqrt(to(a)),
            Self::Sin(a) => Operation::Sin(to(a)),
            Self::Cos(a) => Operation::Cos(to(a)),
            Self::Exp(a) => Operation::Exp(to(a)),
            Self::Ln(a) => Operation::Ln(to(a)),
            Self::Atan2(a, b) => Operation::Atan2(to(a), to(b)),
            Self::Asin(a) => Operation::Asin(to(a)),
            Self::Acos(a) => Operation::Acos(to(a)),
            Self::Tanh(a) => Operation::Tanh(to(a)),
            Self::SelectLt(a, b, x, y) => Operation::SelectLt(to(a), to(b), to(x), to(y)),
        }
    }

    /// Whether nothing is computed: a constant or an input.
    pub(crate) fn is_given(&self) -> bool {
        matches!(self, Self::Constant(_) | Self::Input(_))
    }
}

impl Operation {
    /// Indices of the operands, each once, ascending.
    pub(super) fn distinct_operands(&self) -> impl Iterator<Item = usize> + use<> {
        let mut all: Vec<usize> = self.operands().map(NodeId::index).collect();
        all.sort_unstable();
        all.dedup();
        all.into_iter()
    }
}

impl<T: Scalar> Operation<T> {
    /// The result, over any scalar.
    ///
    /// * `inputs` – all entries of the inputs
    #[inline(always)]
    pub(super) fn apply(self, inputs: &[T]) -> T {
        match self {
            Self::Constant(bits) => T::constant(f64::from_bits(bits)),
            Self::Input(i) => inputs[i as usize],
            Self::Neg(a) => -a,
            Self::Add(a, b) => a + b,
            Self::Sub(a, b) => a - b,
            Self::Mul(a, b) => a * b,
            Self::Div(a, b) => a / b,
            Self::MulAdd(a, b, c) => a.mul_add(b, c),
            Self::MulSub(a, b, c) => a.mul_add(b, -c),
            Self::NegMulAdd(a, b, c) => (-a).mul_add(b, c),
            Self::Sqrt(a) => a.sqrt(),
            Self::Sin(a) => a.sin_cos().0,
            Self::Cos(a) => a.sin_cos().1,
            Self::Exp(a) => a.exp(),
            Self::Ln(a) => a.ln(),
            Self::Atan2(a, b) => a.atan2(b),
            Self::Asin(a) => a.asin(),
            Self::Acos(a) => a.acos(),
            Self::Tanh(a) => a.tanh(),
            Self::SelectLt(a, b, x, y) => a.select_lt(b, x, y),
        }
    }
}
