// Furniture meshes in few bytes, to be carried to a machine that renders training views and has no
// catalogues.
//
// Positions are rounded to 1/65535 of the side of the mesh's box (0.05 mm of a sofa), colours to 64
// steps, and corners that then are one become one. The bytes are laid out for a general compressor
// (planes of differences) and are not compressed themselves.
//
// Layout, little-endian: "DSMODELS", u32 version (1), u32 models, u32 withheld shapes; the models;
// the shapes, 64^3 bits each (the first in the highest bit); SHA-256 of all before it.
// A model: five texts (u16 length, bytes), u8 flags (1: between arms, 2: colours), 6 f4 of the box,
// u32 vertices, u32 faces; each coordinate as u16 differences, high bytes, then low bytes;
// colours as differences of their steps, u8, red, green, blue; corners of faces as numbers of seven
// bits a byte: how far each lies below the lowest vertex that no corner named yet.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/scene/triangle_mesh.h"
#include "deepslam/scene/voxel_grid.h"

namespace deepslam::priors {

struct PackedModel {
  std::string id;  // "scopia/chair"
  std::string class_name;
  std::string source;  // "catalogue" or "folder"
  std::string split;   // "train", "validate" or "withheld"
  std::string credit;
  bool between_arms = false;  // a seat between two arms, which may be given another width
  TriangleMesh mesh;          // object frame (z up, x front), metres
};

struct ModelPack {
  std::vector<PackedModel> models;
  std::vector<VoxelGrid> withheld;  // of every class: what no training model may be like
};

// Errors: a text of 64 KiB or more, a vertex that is not finite, a face whose corner is not there.
[[nodiscard]] Result<std::string> EncodeModelPack(const ModelPack& pack);

// Errors: no such file, cut short, changed, written by a newer program.
[[nodiscard]] Result<ModelPack> DecodeModelPack(std::string_view bytes);

}  // namespace deepslam::priors
