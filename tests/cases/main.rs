//! Laws that hold across modules, frozen references, documents, and other people's meshes.

#[cfg(test)]
mod data;
#[cfg(test)]
mod documents;
#[cfg(test)]
mod equivalent;
#[cfg(test)]
mod examples;
#[cfg(test)]
mod external_meshes;
#[cfg(test)]
mod floors;
#[cfg(test)]
mod layouts;
#[cfg(test)]
mod oracle;
#[cfg(test)]
mod properties;
#[cfg(test)]
mod reference;
#[cfg(test)]
mod same_bundle;
#[cfg(test)]
mod support;
#[cfg(test)]
mod threads;
