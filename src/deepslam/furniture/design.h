// Furniture made up by rules: every seed another design, in the sizes real furniture has.
//
// Shape networks learn from these beside the catalogues' models, which are too few. A design is a
// union of closed solids (solids.h) at real size: metres, z up, x front (the side one sits on or
// opens), y left, origin at the middle of its box.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/random.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::furniture {

enum class Kind {
  kChair,
  kStool,
  kOfficeChair,
  kArmchair,
  kShellChair,
  kTable,
  kRoundTable,
  kDesk,
  kSofa,
  kCornerSofa,
  kSettee,
  kFramedSofa,
  kBed,
  kCabinet,
  kShelf,
};

inline constexpr std::array kKinds = {Kind::kChair,
                                      Kind::kStool,
                                      Kind::kOfficeChair,
                                      Kind::kArmchair,
                                      Kind::kShellChair,
                                      Kind::kTable,
                                      Kind::kRoundTable,
                                      Kind::kDesk,
                                      Kind::kSofa,
                                      Kind::kCornerSofa,
                                      Kind::kSettee,
                                      Kind::kFramedSofa,
                                      Kind::kBed,
                                      Kind::kCabinet,
                                      Kind::kShelf};

[[nodiscard]] std::string_view KindName(Kind kind);  // "office_chair"
// The class of the map that it belongs to: stools, office chairs, armchairs and shells are chairs,
// round tables and desks are tables, settees and framed sofas are sofas.
[[nodiscard]] std::string_view ClassName(Kind kind);
// Kinds of a class with the share that each has of its designs; empty for a class without any.
struct KindShare {
  Kind kind;
  double share;
};
[[nodiscard]] std::span<const KindShare> KindsOfClass(std::string_view class_name);

// Bounds of real extents, metres; every design keeps to them.
struct SizeRange {
  Eigen::Vector3d min_m;  // along x (front), y, z
  Eigen::Vector3d max_m;
};
[[nodiscard]] SizeRange SizeRangeOf(Kind kind);

struct Design {
  Kind kind = Kind::kChair;
  TriangleMesh mesh;
  std::vector<std::uint8_t> material_of_face;  // solids.h: Material
  std::vector<std::uint32_t> first_faces;      // of each closed solid, ascending
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
};

// A function of kind and random numbers alone.
[[nodiscard]] Design MakeDesign(Kind kind, Random random);

}  // namespace deepslam::furniture
