//! Materials in JSON: one kind beside an optional texture, `{"matte": {...}, "texture": "wood.png"}`.

use crate::model::MaterialKind;
use eosphor_core::texture::{TextureFilter, TextureWrap};
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{
    self, DeserializeSeed, Deserializer, EnumAccess, IntoDeserializer, MapAccess, VariantAccess, Visitor,
};
use std::fmt;
use std::marker::PhantomData;
use std::path::PathBuf;

/// One material.
pub(super) struct MaterialEntry {
    pub(super) kind: MaterialKind,
    pub(super) texture: Option<TextureEntry>,
}

/// A texture by file, relative to the scene file.
#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct TextureFields {
    file: PathBuf,
    #[serde(default = "bilinear")]
    filter: TextureFilter,
    #[serde(default = "repeat")]
    wrap: TextureWrap,
}

fn bilinear() -> TextureFilter {
    TextureFilter::Bilinear
}

fn repeat() -> TextureWrap {
    TextureWrap::Repeat
}

/// A file name alone or with how it is read.
pub(super) struct TextureEntry {
    pub(super) file: PathBuf,
    pub(super) filter: TextureFilter,
    pub(super) wrap: TextureWrap,
}

impl From<TextureFields> for TextureEntry {
    fn from(TextureFields { file, filter, wrap }: TextureFields) -> TextureEntry {
        TextureEntry { file, filter, wrap }
    }
}

impl<'de> Deserialize<'de> for TextureEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<TextureEntry, D::Error> {
        struct FileOrFields;
        impl<'de> Visitor<'de> for FileOrFields {
            type Value = TextureEntry;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a file name or {\"file\", \"filter\", \"wrap\"}")
            }
            fn visit_str<E: de::Error>(self, file: &str) -> Result<TextureEntry, E> {
                Ok(TextureFields { file: file.into(), filter: bilinear(), wrap: repeat() }.into())
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<TextureEntry, A::Error> {
                TextureFields::deserialize(MapAccessDeserializer::new(map)).map(TextureEntry::from)
            }
        }
        deserializer.deserialize_any(FileOrFields)
    }
}

// serde's flatten would do this but for unknown fields and the positions of errors, which it loses.
impl<'de> Deserialize<'de> for MaterialEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<MaterialEntry, D::Error> {
        struct KindAndTexture;
        impl<'de> Visitor<'de> for KindAndTexture {
            type Value = MaterialEntry;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a material, such as {\"matte\": {\"color\": [1, 1, 1]}}")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<MaterialEntry, A::Error> {
                let (mut kind, mut texture) = (None, None);
                while let Some(key) = map.next_key::<String>()? {
                    if key == "texture" {
                        if texture.replace(map.next_value()?).is_some() {
                            return Err(de::Error::duplicate_field("texture"));
                        }
                    } else if kind.is_some() {
                        return Err(de::Error::custom(format!(
                            "\"{key}\": a material has one kind and a texture"
                        )));
                    } else {
                        kind = Some(map.next_value_seed(Kind(&key))?);
                    }
                }
                let kind =
                    kind.ok_or_else(|| de::Error::custom("the material has no kind, such as \"matte\""))?;
                Ok(MaterialEntry { kind, texture })
            }
        }
        deserializer.deserialize_map(KindAndTexture)
    }
}

/// Reads the value of a known variant name.
struct Kind<'a>(&'a str);

impl<'de> DeserializeSeed<'de> for Kind<'_> {
    type Value = MaterialKind;
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<MaterialKind, D::Error> {
        MaterialKind::deserialize(Variant { name: self.0, value: deserializer })
    }
}

/// An enum whose variant name is known and whose contents follow.
struct Variant<'a, D> {
    name: &'a str,
    value: D,
}

impl<'de, D: Deserializer<'de>> Deserializer<'de> for Variant<'_, D> {
    type Error = D::Error;
    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
        visitor.visit_enum(self)
    }
    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map struct enum identifier ignored_any
    }
}

impl<'de, D: Deserializer<'de>> EnumAccess<'de> for Variant<'_, D> {
    type Error = D::Error;
    type Variant = Contents<D>;
    fn variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<(S::Value, Contents<D>), D::Error> {
        Ok((seed.deserialize(self.name.into_deserializer())?, Contents(self.value)))
    }
}

struct Contents<D>(D);

impl<'de, D: Deserializer<'de>> VariantAccess<'de> for Contents<D> {
    type Error = D::Error;
    fn unit_variant(self) -> Result<(), D::Error> {
        de::Deserialize::deserialize(self.0)
    }
    fn newtype_variant_seed<S: DeserializeSeed<'de>>(self, seed: S) -> Result<S::Value, D::Error> {
        seed.deserialize(self.0)
    }
    fn tuple_variant<V: Visitor<'de>>(self, len: usize, visitor: V) -> Result<V::Value, D::Error> {
        self.0.deserialize_tuple(len, visitor)
    }
    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        self.0.deserialize_struct("material", fields, visitor)
    }
}

/// A JSON object as a list in the file's order; a name given twice is an error.
pub(super) struct Entries<T>(pub(super) Vec<(String, T)>);

impl<T> Default for Entries<T> {
    fn default() -> Entries<T> {
        Entries(Vec::new())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Entries<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Entries<T>, D::Error> {
        struct List<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for List<T> {
            type Value = Entries<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object of names and values")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Entries<T>, A::Error> {
                let mut list: Vec<(String, T)> = Vec::new();
                let mut names = std::collections::HashSet::new();
                while let Some(name) = map.next_key::<String>()? {
                    if !names.insert(name.clone()) {
                        return Err(de::Error::custom(format!("the name \"{name}\" is given twice")));
                    }
                    list.push((name, map.next_value()?));
                }
                Ok(Entries(list))
            }
        }
        deserializer.deserialize_map(List(PhantomData))
    }
}
