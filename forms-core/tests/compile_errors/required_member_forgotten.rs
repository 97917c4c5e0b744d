use forms_core::contract::Given;
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
    let data: heat::Data<2> = heat::Required { k: 1.0 }.into();
    let data = heat::Data { f: Given::constant(1.0), ..heat::Required { gap: data.gap }.into() };
    drop(heat::Data { f: data.f, k: 1.0 });
}
