//! One declaration of the parameters of a type, from which casts, checks, names and seeds follow.
//!
//! [`numbers!`] lists the fields of a struct, or of the variants of an enum, once. The pattern that it makes of them names every field, so that one that is forgotten
//! does not compile.
//!
//! | field | meaning |
//! |---|---|
//! | `Positive("name")` | a parameter: its [`Domain`], and its name in layouts and messages |
//! | `Positive("name", "quantity")` | with other words in messages |
//! | `Finite(["slope x", "slope y"], "quantity")` | an array or a vector of parameters |
//! | `part(Type)` | a part that has a declaration of its own, or an `Option`, array or `Vec` of it |
//! | `part(Type, "stop {}", "{} of a joint limit")` | with other words around its names and quantities |
//! | `parameters("quantity")` | a `Vec` of parameters that a user's function takes |
//! | `hidden()` | parameters that cannot be set one by one |
//! | `kept()` | no number |
//!
//! With `pub` in front the type has the public trait [`Cast`](crate::scalar::Cast).

use std::fmt::Display;

use nalgebra::SMatrix;

use crate::scalar::{Dual, MapEach, Over, Scalar};

/// Values that a number may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Domain {
    Anything,
    Finite,
    /// Finite, and in an order with another number, which the type checks that has both.
    Ordered,
    NotNegative,
    /// Not negative, and in an order with another number.
    NotNegativeOrdered,
    NotNegativeOrInfinite,
    Positive,
    /// From 0 to 1.
    WithinOne,
    /// Between 0 and 1, which are none of them.
    Fraction,
    AtLeastOne,
}

impl Domain {
    pub(crate) fn contains(self, x: f64) -> bool {
        match self {
            Self::Anything => true,
            Self::Finite | Self::Ordered => x.is_finite(),
            Self::NotNegative | Self::NotNegativeOrdered => x >= 0.0 && x.is_finite(),
            Self::NotNegativeOrInfinite => x >= 0.0,
            Self::Positive => x > 0.0 && x.is_finite(),
            Self::WithinOne => (0.0..=1.0).contains(&x),
            Self::Fraction => x > 0.0 && x < 1.0,
            Self::AtLeastOne => x >= 1.0 && x.is_finite(),
        }
    }

    /// # Panics
    /// If a lane of a number is outside of the domain, with the quantity and its value.
    pub(crate) fn check<P: Scalar>(self, quantity: impl Display, x: P) {
        each_lane([x], |[x]| match self {
            Self::Fraction | Self::AtLeastOne => self.hold(format_args!("a {quantity} of {x}"), x),
            _ => assert!(self.contains(x), "the {quantity} is {x}: {}", self.lack()),
        });
    }

    /// # Panics
    /// If a value is outside of the domain, with a phrase that has the quantity and the value.
    pub(crate) fn hold(self, phrase: impl Display, x: f64) {
        assert!(self.contains(x), "{phrase} is {}", self.lack());
    }

    /// Property of the values outside.
    fn lack(self) -> &'static str {
        match self {
            Self::Anything | Self::Finite | Self::Ordered => "not finite",
            Self::NotNegative | Self::NotNegativeOrdered => "negative or not finite",
            Self::NotNegativeOrInfinite => "negative or not a number",
            Self::Positive => "not positive and finite",
            Self::WithinOne => "not in 0..1",
            Self::Fraction => "not between 0 and 1",
            Self::AtLeastOne => "not finite and at least 1",
        }
    }
}

/// Whether a number is neither infinite nor NaN, in every lane.
pub(crate) fn is_finite<P: Scalar>(x: P) -> bool {
    !x.has_value() || (0..P::LANES).all(|lane| x.value(lane).is_finite())
}

/// Passes the values of some numbers to a check, lane by lane; nothing where one of them has none.
pub(crate) fn each_lane<P: Scalar, const N: usize>(x: [P; N], check: impl Fn([f64; N])) {
    if x.iter().all(P::has_value) {
        (0..P::LANES).for_each(|lane| check(x.map_each(|x| x.value(lane))));
    }
}

/// Description of a number.
#[derive(Clone, Copy)]
pub(crate) struct Number<'a> {
    /// In layouts of parameters.
    pub(crate) name: &'a dyn Display,
    /// In messages.
    pub(crate) quantity: &'a dyn Display,
    pub(crate) domain: Domain,
}

impl<'a> Number<'a> {
    /// Describes a number by its name, its quantity and its domain.
    pub(crate) fn new(name: &'a dyn Display, quantity: &'a dyn Display, domain: Domain) -> Self {
        Self {
            name,
            quantity,
            domain,
        }
    }
}

/// A function of each parameter with its description.
pub(crate) type Each<'a, P> = dyn FnMut(Number<'_>, &mut P) + 'a;

/// A function of each parameter with its group and description.
pub(crate) type EachIn<'a, G, P> = dyn FnMut(G, Number<'_>, &mut P) + 'a;

/// Passes each number on as one of a group.
pub(crate) fn of<G: Copy, P>(
    group: G,
    each: &mut EachIn<'_, G, P>,
) -> impl FnMut(Number<'_>, &mut P) {
    move |own, x| each(group, own, x)
}

/// A type with numbers over a scalar; [`numbers!`] implements it.
pub(crate) trait Numbers<P: Scalar>: Clone {
    /// The type over another scalar.
    type With<Q: Scalar>: Numbers<Q>;

    /// The most parameters that it has, where a part of which there are several counts once.
    const COUNT: usize;

    /// Replaces each number by its image.
    fn map_numbers<Q: Scalar>(&self, to: &mut impl FnMut(P) -> Q) -> Self::With<Q>;

    /// Passes each parameter with its description to `each`, in the order of the declaration.
    fn each_number(&mut self, each: &mut Each<'_, P>);

    /// The numbers over another scalar.
    fn lift<Q: Over<P>>(&self) -> Self::With<Q> {
        self.map_numbers(&mut |x| Q::from(x))
    }

    /// The numbers over dual numbers, each parameter with the derivative in itself, in directions from the first on.
    fn seed<T: Scalar, const N: usize>(&self, first: usize) -> Self::With<Dual<T, N>>
    where
        Dual<T, N>: Over<P>,
    {
        let (mut out, mut direction) = (self.lift(), first);
        out.each_number(&mut |_, x: &mut Dual<T, N>| {
            x.eps[direction] = T::one();
            direction += 1;
        });
        out
    }

    /// Collects the parameters. Allocates.
    fn to_vec(&self) -> Vec<P> {
        let mut out = Vec::new();
        self.clone().each_number(&mut |_, x| out.push(*x));
        out
    }

    /// # Panics
    /// If a parameter is outside of its domain.
    fn check_numbers(&self) {
        self.clone()
            .each_number(&mut |own, &mut x| own.domain.check(own.quantity, x));
    }
}

/// Implements [`Numbers`] for several parts.
macro_rules! several {
    ([$($n:ident)?] $Own:ty => $With:ty, |$own:ident, $to:ident| $map:expr) => {
        impl<P: Scalar, X: Numbers<P> $(, const $n: usize)?> Numbers<P> for $Own {
            type With<Q: Scalar> = $With;
            const COUNT: usize = X::COUNT;

            fn map_numbers<Q: Scalar>(&self, $to: &mut impl FnMut(P) -> Q) -> Self::With<Q> {
                let $own = self;
                $map
            }

            fn each_number(&mut self, each: &mut Each<'_, P>) {
                self.iter_mut().for_each(|own| own.each_number(each));
            }
        }
    };
}

several!([] Option<X> => Option<X::With<Q>>, |own, to| own.as_ref().map(|x| x.map_numbers(to)));
several!([] Vec<X> => Vec<X::With<Q>>, |own, to| own.iter().map(|x| x.map_numbers(to)).collect());
several!([N] [X; N] => [X::With<Q>; N], |own, to| own.each_ref().map(|x| x.map_numbers(to)));

/// Numbers that a field holds itself: one, one that may be missing, or several side by side.
pub(crate) trait Held<P> {
    /// The field over another scalar.
    type With<Q: Scalar>;

    /// Replaces each number by its image.
    fn map_held<Q: Scalar>(&self, to: &mut impl FnMut(P) -> Q) -> Self::With<Q>;

    /// The numbers, to be changed.
    fn as_mut(&mut self) -> &mut [P];
}

/// Implements [`Held`] for the type of a field.
macro_rules! held {
    ([$($n:ident)*] $Own:ty => $With:ty, |$own:ident, $to:ident| $map:expr, $slice:expr) => {
        impl<P: Scalar, $(const $n: usize),*> Held<P> for $Own {
            type With<Q: Scalar> = $With;

            #[inline]
            fn map_held<Q: Scalar>(&self, $to: &mut impl FnMut(P) -> Q) -> Self::With<Q> {
                let $own = self;
                $map
            }

            fn as_mut(&mut self) -> &mut [P] {
                $slice(self)
            }
        }
    };
}

held!([] P => Q, |own, to| to(*own), std::slice::from_mut);
held!([] Option<P> => Option<Q>, |own, to| (*own).map(to), Self::as_mut_slice);
held!([] Vec<P> => Vec<Q>, |own, to| own.iter().map(|&x| to(x)).collect(), Self::as_mut_slice);
held!([N] [P; N] => [Q; N], |own, to| (*own).map_each(to), Self::as_mut_slice);
held!([R C] SMatrix<P, R, C> => SMatrix<Q, R, C>, |own, to| own.map(to), Self::as_mut_slice);

/// Passes values with their names to `each`; without a quantity, the name is used.
pub(crate) fn each_named<P>(
    names: &[&str],
    quantity: Option<&dyn Display>,
    domain: Domain,
    numbers: &mut [P],
    each: &mut Each<'_, P>,
) {
    for (name, x) in names.iter().zip(numbers) {
        each(Number::new(name, quantity.unwrap_or(name), domain), x);
    }
}

/// Passes the parameters of a user's function to `each`.
pub(crate) fn each_parameter<P>(quantity: &dyn Display, own: &mut [P], each: &mut Each<'_, P>) {
    for (k, x) in own.iter_mut().enumerate() {
        let name = format_args!("parameter {k}");
        each(Number::new(&name, quantity, Domain::Finite), x);
    }
}

/// The largest of some counts.
pub(crate) const fn most(counts: &[usize]) -> usize {
    let (mut out, mut k) = (0, 0);
    while k < counts.len() {
        out = if counts[k] > out { counts[k] } else { out };
        k += 1;
    }
    out
}

/// Declares the parameters of a type; see the [module](self).
macro_rules! numbers {
    (pub $sort:ident $T:ident $fields:tt) => {
        numbers! { $sort $T $fields }

        impl<P: $crate::scalar::Scalar> $crate::scalar::Cast<P> for $T<P> {
            type To<Q: $crate::scalar::Scalar> = $T<Q>;

            fn cast<Q: $crate::scalar::Over<P>>(&self) -> $T<Q> {
                $crate::numbers::Numbers::lift(self)
            }
        }
    };
    (struct $T:ident $fields:tt) => { numbers! { of $T [$T $fields] } };
    (enum $T:ident { $($V:ident $fields:tt),* $(,)? }) => {
        numbers! { of $T $([$T::$V $fields])* }
    };
    (of $T:ident $([$($path:ident)::+
        $({ $($field:ident: $sort:ident $words:tt),* $(,)? })?
        $(($own:ident: $own_sort:ident $own_words:tt))?
    ])*) => {
        impl<P: $crate::scalar::Scalar> $crate::numbers::Numbers<P> for $T<P> {
            type With<Q: $crate::scalar::Scalar> = $T<Q>;
            const COUNT: usize = $crate::numbers::most(&[$(
                0 $($(+ numbers!(count $sort $words))*)? $(+ numbers!(count $own_sort $own_words))?
            ),*]);

            #[inline]
            fn map_numbers<Q: $crate::scalar::Scalar>(&self, to: &mut impl FnMut(P) -> Q) -> $T<Q> {
                match self {$(
                    $($path)::+ $({ $($field),* })? $(($own))? => $($path)::+
                        $({ $($field: numbers!(map $sort $field to)),* })?
                        $((numbers!(map $own_sort $own to)))?,
                )*}
            }

            #[allow(unused_variables, reason = "where there are no parameters")]
            fn each_number(&mut self, each: &mut $crate::numbers::Each<'_, P>) {
                match self {$(
                    $($path)::+ $({ $($field),* })? $(($own))? => {
                        $($(numbers!(each $sort $field each $words);)*)?
                        $(numbers!(each $own_sort $own each $own_words);)?
                    }
                )*}
            }
        }
    };

    (map kept $x:ident $to:ident) => { $x.clone() };
    (map part $x:ident $to:ident) => { $crate::numbers::Numbers::<P>::map_numbers($x, $to) };
    (map $domain:ident $x:ident $to:ident) => { $crate::numbers::Held::<P>::map_held($x, $to) };

    (each kept $x:ident $each:ident ()) => {};
    (each hidden $x:ident $each:ident ()) => {};
    (each part $x:ident $each:ident ($Part:ident)) => {
        $crate::numbers::Numbers::<P>::each_number($x, $each)
    };
    (each part $x:ident $each:ident ($Part:ident, $name:literal, $quantity:literal)) => {
        $crate::numbers::Numbers::<P>::each_number($x, &mut |own, x| {
            let name = format_args!($name, own.name);
            let quantity = format_args!($quantity, own.quantity);
            $each($crate::numbers::Number::new(&name, &quantity, own.domain), x);
        })
    };
    (each parameters $x:ident $each:ident ($quantity:literal)) => {
        $crate::numbers::each_parameter(&$quantity, $x, $each)
    };
    (each $domain:ident $x:ident $each:ident ($names:tt $(, $quantity:literal)?)) => {
        $crate::numbers::each_named(
            numbers!(names $names),
            numbers!(quantity $($quantity)?),
            $crate::numbers::Domain::$domain,
            $crate::numbers::Held::<P>::as_mut($x),
            $each,
        )
    };
    (quantity) => { None };
    (quantity $quantity:literal) => { Some(&$quantity) };

    (count kept ()) => { 0 };
    (count hidden ()) => { 0 };
    (count parameters $words:tt) => { 0 };
    (count part ($Part:ident $($words:tt)*)) => {
        <$Part<f64> as $crate::numbers::Numbers<f64>>::COUNT
    };
    (count $domain:ident ($names:tt $($words:tt)*)) => { numbers!(names $names).len() };

    (names $name:literal) => { &[$name] };
    (names $names:tt) => { &$names };
}
pub(crate) use numbers;

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Debug, PartialEq)]
    enum Joint<P> {
        Rigid,
        Sprung(Spring<P>),
        Bushing {
            springs: Vec<Spring<P>>,
            center: [P; 2],
            limit: Option<P>,
            axis: [P; 2],
            name: &'static str,
        },
    }

    #[derive(Clone, Debug, PartialEq)]
    struct Spring<P> {
        stiffness: P,
        rest: P,
    }

    numbers! { enum Joint {
        Rigid {},
        Sprung(own: part(Spring)),
        Bushing {
            springs: part(Spring, "bushing {}", "{} of a bushing"),
            center: Finite(["x", "y"], "centre"),
            limit: Positive("limit"),
            axis: hidden(),
            name: kept(),
        },
    } }

    numbers! { struct Spring { stiffness: NotNegative("stiffness"), rest: Finite("rest", "rest position") } }

    fn bushing() -> Joint<f64> {
        Joint::Bushing {
            springs: vec![Spring {
                stiffness: 1.0,
                rest: 2.0,
            }],
            center: [3.0, 4.0],
            limit: Some(5.0),
            axis: [0.0, 1.0],
            name: "rubber",
        }
    }

    #[test]
    fn numbers_are_visited_in_the_order_of_their_declaration() {
        let mut said = Vec::new();
        bushing()
            .each_number(&mut |own, x| said.push(format!("{} {} {x}", own.name, own.quantity)));
        let expected = [
            "bushing stiffness stiffness of a bushing 1",
            "bushing rest rest position of a bushing 2",
            "x centre 3",
            "y centre 4",
            "limit limit 5",
        ];
        assert_eq!(said, expected);
        assert!(Joint::<f64>::Rigid.to_vec().is_empty());
        let sprung = Joint::Sprung(Spring {
            stiffness: 1.0,
            rest: 2.0,
        });
        assert_eq!(sprung.to_vec(), [1.0, 2.0]);
        assert_eq!(<Joint<f64> as Numbers<f64>>::COUNT, 5);
    }

    #[test]
    fn seeded_numbers_have_their_own_directions_and_hidden_ones_none() {
        let seeded = bushing().seed::<f64, 7>(2);
        let directions = seeded.to_vec().into_iter().enumerate();
        for (k, x) in directions {
            assert_eq!(x, Dual::variable(1.0 + k as f64, 2 + k));
        }
        let Joint::Bushing { axis, .. } = &seeded else {
            panic!("of the same variant")
        };
        assert_eq!(
            axis.map(|x| (x.re, x.eps)),
            [(0.0, [0.0; 7]), (1.0, [0.0; 7])]
        );
        assert_eq!(seeded.map_numbers(&mut |x| x.re), bushing());
    }

    #[test]
    fn domains_contain_their_ends_as_they_say() {
        use Domain::*;
        let (inf, nan) = (f64::INFINITY, f64::NAN);
        for (domain, inside, outside) in [
            (Anything, vec![-inf, nan], vec![]),
            (Finite, vec![-1e300, 0.0], vec![inf, nan]),
            (NotNegative, vec![0.0, 1e300], vec![-1e-300, inf, nan]),
            (NotNegativeOrInfinite, vec![0.0, inf], vec![-1.0, nan]),
            (Positive, vec![1e-300], vec![0.0, -1.0, inf, nan]),
            (WithinOne, vec![0.0, 1.0], vec![-0.1, 1.1, nan]),
            (Fraction, vec![0.5], vec![0.0, 1.0, nan]),
            (AtLeastOne, vec![1.0], vec![0.9, inf, nan]),
        ] {
            assert!(inside.iter().all(|&x| domain.contains(x)), "{domain:?}");
            assert!(!outside.iter().any(|&x| domain.contains(x)), "{domain:?}");
        }
    }

    #[test]
    #[should_panic(expected = "the stiffness of a bushing is -1: negative or not finite")]
    fn number_of_a_part_is_refused_with_its_whole_name() {
        let mut odd = bushing();
        odd.each_number(&mut |_, x| *x = -1.0);
        odd.check_numbers();
    }
}
