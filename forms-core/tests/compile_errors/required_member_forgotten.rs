use forms_core::forms;

#[forms(crate = forms_core)]
pub mod heat {
    pub struct Data {
        pub k: Param,
        pub gap: Given<Scalar>,
        #[default(0)]
        pub f: Given<Scalar>,
    }
}

fn main() {
    let _: heat::Data<2> = heat::data().k(1.0);
    let _: heat::Data<2> = heat::data().gap(0.1);
    let _: heat::Data<2> = heat::data().k(1).gap("0.1").f(1);
    let _: heat::Data<2> = heat::data().k(1.0).gap([0.1, 0.2]).f(|x: &[f64; 2]| *x);
    let _: heat::Data<2> = heat::data().k(1.0).gap(0.1).f(|x: &[f64; 3]| x[2]);
}
