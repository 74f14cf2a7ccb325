//! Films in parts: a plan, parts that are rendered one by one on any machine, and the film that they are joined to.
//!
//! A [plan](plan::Plan) is the result of one cheap [pass](survey::survey) over the film: where its shots begin, by number of
//! frame. A mesh begins anew at every cut, so a part of whole shots has the meshes that a render of the whole film
//! has. Parts are mesh streams; joined, they are painted and encoded once, as one film. So a join is exact whatever
//! the output is.
//!
//! Nothing depends on a seek being right: the plan holds a [hash](hash) of every shot's frames and times, and a part
//! whose frames are others is not written.

pub mod hash;
pub mod part;
pub mod parts;
pub mod plan;
pub mod range;
pub mod survey;
