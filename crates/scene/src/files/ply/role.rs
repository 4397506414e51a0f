//! What elements and properties mean, by their names.

use super::header::{Element, Header, Shape};

/// What the rows of an element are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Vertex,
    Face,
    /// Triangle strips, as in Stanford's files.
    Strips,
    Other,
}

/// What a property is to us. Numbers of vertices go to a slot of their row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    Skip,
    /// A coordinate, by slot.
    Number(usize),
    /// R, G, B or opacity, by slot.
    Color(usize),
    /// The list of a polygon's or strip's vertices.
    Indices,
    /// u and v of each corner of a polygon.
    CornerUvs,
    /// Which of the file's pictures a polygon shows.
    TextureNumber,
    /// A colour of a whole face: said, not read.
    FaceColor,
}

pub(super) const POSITION: usize = 0;
pub(super) const NORMAL: usize = 3;
pub(super) const COLOR: usize = 6;
pub(super) const UV: usize = 10;
/// Slots of a vertex.
pub(super) const SLOTS: usize = 12;

impl Kind {
    pub(super) fn of_name(name: &[u8]) -> Kind {
        match name.to_ascii_lowercase().as_slice() {
            b"vertex" => Kind::Vertex,
            b"face" => Kind::Face,
            b"tristrips" | b"tri_strips" => Kind::Strips,
            _ => Kind::Other,
        }
    }
}

impl Role {
    pub(super) fn of(kind: Kind, name: &[u8], shape: Shape) -> Role {
        let name = name.to_ascii_lowercase();
        match (kind, shape) {
            (Kind::Vertex, Shape::One(_)) => Role::of_vertex(&name),
            (Kind::Face, Shape::One(scalar)) => match name.as_slice() {
                b"texnumber" if scalar.is_whole() => Role::TextureNumber,
                b"red" | b"diffuse_red" => Role::FaceColor,
                _ => Role::Skip,
            },
            (Kind::Face | Kind::Strips, Shape::List { item, .. }) => match name.as_slice() {
                b"vertex_indices" | b"vertex_index" if item.is_whole() => Role::Indices,
                b"texcoord" if kind == Kind::Face => Role::CornerUvs,
                _ => Role::Skip,
            },
            _ => Role::Skip,
        }
    }

    fn of_vertex(name: &[u8]) -> Role {
        match name.strip_prefix(b"diffuse_").unwrap_or(name) {
            b"red" | b"r" => return Role::Color(COLOR),
            b"green" | b"g" => return Role::Color(COLOR + 1),
            b"blue" | b"b" => return Role::Color(COLOR + 2),
            b"alpha" | b"a" => return Role::Color(COLOR + 3),
            _ => {}
        }
        match name {
            b"x" => Role::Number(POSITION),
            b"y" => Role::Number(POSITION + 1),
            b"z" => Role::Number(POSITION + 2),
            b"nx" => Role::Number(NORMAL),
            b"ny" => Role::Number(NORMAL + 1),
            b"nz" => Role::Number(NORMAL + 2),
            b"s" | b"u" | b"texture_u" | b"texture_s" => Role::Number(UV),
            b"t" | b"v" | b"texture_v" | b"texture_t" => Role::Number(UV + 1),
            _ => Role::Skip,
        }
    }
}

/// What the vertices and faces of a file have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plan {
    /// Positions are counted from here, in double precision where it is not 0.
    pub(super) origin: [f64; 3],
    pub(super) positions: bool,
    pub(super) normals: bool,
    pub(super) colors: bool,
    /// Texture coordinates of vertices. Those of corners win.
    pub(super) uvs: bool,
    pub(super) corner_uvs: bool,
    pub(super) face_colors: bool,
}

impl Plan {
    /// Whether positions are counted from 0, in single precision.
    #[inline(always)]
    pub(super) fn is_near(&self) -> bool {
        self.origin == [0.0; 3]
    }

    pub(super) fn of(header: &Header) -> Plan {
        let vertex = header.elements.iter().find(|e| e.kind == Kind::Vertex);
        let number = |slots: std::ops::Range<usize>| {
            vertex.is_some_and(|v| slots.clone().all(|slot| v.has(Role::Number(slot))))
        };
        let any_face = |role: Role| header.elements.iter().any(|e: &Element| e.count > 0 && e.has(role));
        let corner_uvs = any_face(Role::CornerUvs);
        Plan {
            origin: [0.0; 3],
            positions: number(POSITION..POSITION + 3),
            normals: number(NORMAL..NORMAL + 3),
            colors: vertex.is_some_and(|v| (COLOR..COLOR + 3).all(|slot| v.has(Role::Color(slot)))),
            uvs: number(UV..UV + 2) && !corner_uvs,
            corner_uvs,
            face_colors: any_face(Role::FaceColor),
        }
    }
}
