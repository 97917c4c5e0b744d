use forms_core::forms;

#[forms(crate = forms_core)]
pub mod deep {
    #[cells]
    pub struct Omega;

    fn f0(w: Scalar) -> Scalar {
        f1(w + 1) * f1(w + 2)
    }
    fn f1(w: Scalar) -> Scalar {
        f2(w + 1) * f2(w + 2)
    }
    fn f2(w: Scalar) -> Scalar {
        f3(w + 1) * f3(w + 2)
    }
    fn f3(w: Scalar) -> Scalar {
        f4(w + 1) * f4(w + 2)
    }
    fn f4(w: Scalar) -> Scalar {
        f5(w + 1) * f5(w + 2)
    }
    fn f5(w: Scalar) -> Scalar {
        f6(w + 1) * f6(w + 2)
    }
    fn f6(w: Scalar) -> Scalar {
        f7(w + 1) * f7(w + 2)
    }
    fn f7(w: Scalar) -> Scalar {
        f8(w + 1) * f8(w + 2)
    }
    fn f8(w: Scalar) -> Scalar {
        f9(w + 1) * f9(w + 2)
    }
    fn f9(w: Scalar) -> Scalar {
        f10(w + 1) * f10(w + 2)
    }
    fn f10(w: Scalar) -> Scalar {
        f11(w + 1) * f11(w + 2)
    }
    fn f11(w: Scalar) -> Scalar {
        f12(w + 1) * f12(w + 2)
    }
    fn f12(w: Scalar) -> Scalar {
        f13(w + 1) * f13(w + 2)
    }
    fn f13(w: Scalar) -> Scalar {
        f14(w + 1) * f14(w + 2)
    }
    fn f14(w: Scalar) -> Scalar {
        f15(w + 1) * f15(w + 2)
    }
    fn f15(w: Scalar) -> Scalar {
        f16(w + 1) * f16(w + 2)
    }
    fn f16(w: Scalar) -> Scalar {
        f17(w + 1) * f17(w + 2)
    }
    fn f17(w: Scalar) -> Scalar {
        f18(w + 1) * f18(w + 2)
    }
    fn f18(w: Scalar) -> Scalar {
        f19(w + 1) * f19(w + 2)
    }
    fn f19(w: Scalar) -> Scalar {
        f20(w + 1) * f20(w + 2)
    }
    fn f20(w: Scalar) -> Scalar {
        f21(w + 1) * f21(w + 2)
    }
    fn f21(w: Scalar) -> Scalar {
        f22(w + 1) * f22(w + 2)
    }
    fn f22(w: Scalar) -> Scalar {
        f23(w + 1) * f23(w + 2)
    }
    fn f23(w: Scalar) -> Scalar {
        f24(w + 1) * f24(w + 2)
    }
    fn f24(w: Scalar) -> Scalar {
        f25(w + 1) * f25(w + 2)
    }
    fn f25(w: Scalar) -> Scalar {
        f26(w + 1) * f26(w + 2)
    }
    fn f26(w: Scalar) -> Scalar {
        f27(w + 1) * f27(w + 2)
    }
    fn f27(w: Scalar) -> Scalar {
        f28(w + 1) * f28(w + 2)
    }
    fn f28(w: Scalar) -> Scalar {
        f29(w + 1) * f29(w + 2)
    }
    fn f29(w: Scalar) -> Scalar {
        f30(w + 1) * f30(w + 2)
    }
    fn f30(w: Scalar) -> Scalar {
        f31(w + 1) * f31(w + 2)
    }
    fn f31(w: Scalar) -> Scalar {
        f32(w + 1) * f32(w + 2)
    }
    fn f32(w: Scalar) -> Scalar {
        f33(w + 1) * f33(w + 2)
    }
    fn f33(w: Scalar) -> Scalar {
        f34(w + 1) * f34(w + 2)
    }
    fn f34(w: Scalar) -> Scalar {
        f35(w + 1) * f35(w + 2)
    }
    fn f35(w: Scalar) -> Scalar {
        f36(w + 1) * f36(w + 2)
    }
    fn f36(w: Scalar) -> Scalar {
        f37(w + 1) * f37(w + 2)
    }
    fn f37(w: Scalar) -> Scalar {
        f38(w + 1) * f38(w + 2)
    }
    fn f38(w: Scalar) -> Scalar {
        f39(w + 1) * f39(w + 2)
    }
    fn f39(w: Scalar) -> Scalar {
        f40(w + 1) * f40(w + 2)
    }
    fn f40(w: Scalar) -> Scalar {
        w
    }
    pub fn right(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, u * v)
    }
    pub fn wrong(u: Unknown<Scalar>) -> Energy {
        integral(Omega, f0(u))
    }
}

#[forms(crate = forms_core)]
pub mod wide {
    #[cells]
    pub struct Omega;

    fn many(w: Scalar) -> Functional {
        let one = integral(Omega, w);
        let two = one + one + one + one + one + one + one + one + one + one;
        let three = two + two + two + two + two + two + two + two + two + two;
        let four = three + three + three + three + three + three + three + three + three + three;
        let five = four + four + four + four + four + four + four + four + four + four;
        five + five
    }
    pub fn integrals(u: State<Scalar>) -> Functional {
        many(u)
    }
}

/// A use of the module: it gives no further errors.
fn main() {
    let omega = deep::Omega::on("all");
    let (right, wrong) = (deep::right::<2>(&omega), deep::wrong::<2>(&omega));
    drop((right, wrong));
}
