//! +, −, ×, ÷ of [`Real`]s by value and by reference, and with an exact `f64` on the right.

use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Sub, SubAssign};

use astro_float_num::BigFloat;

use crate::real::Real;

macro_rules! operator {
    ($operator:ident, $method:ident, $assign:ident, $assign_method:ident) => {
        operator!($operator, $method);

        impl $assign<&Real> for Real {
            fn $assign_method(&mut self, other: &Real) {
                *self = (&*self).$method(other);
            }
        }

        impl $assign for Real {
            fn $assign_method(&mut self, other: Real) {
                *self = (&*self).$method(&other);
            }
        }
    };
    ($operator:ident, $method:ident) => {
        impl $operator<&Real> for &Real {
            type Output = Real;
            fn $method(self, other: &Real) -> Real {
                self.combine(other, BigFloat::$method)
            }
        }

        impl $operator<Real> for &Real {
            type Output = Real;
            fn $method(self, other: Real) -> Real {
                self.$method(&other)
            }
        }

        impl $operator<&Real> for Real {
            type Output = Real;
            fn $method(self, other: &Real) -> Real {
                (&self).$method(other)
            }
        }

        impl $operator for Real {
            type Output = Real;
            fn $method(self, other: Real) -> Real {
                (&self).$method(&other)
            }
        }

        impl $operator<f64> for &Real {
            type Output = Real;
            fn $method(self, other: f64) -> Real {
                self.$method(&Real::new(other, 64))
            }
        }

        impl $operator<f64> for Real {
            type Output = Real;
            fn $method(self, other: f64) -> Real {
                (&self).$method(&Real::new(other, 64))
            }
        }
    };
}

operator!(Add, add, AddAssign, add_assign);
operator!(Sub, sub, SubAssign, sub_assign);
operator!(Mul, mul, MulAssign, mul_assign);
operator!(Div, div);
