#include "deepslam/furniture/design.h"

#include "deepslam/core/check.h"
#include "deepslam/furniture/kinds.h"
#include "deepslam/furniture/solids.h"

namespace deepslam::furniture {
namespace {

struct KindEntry {
  Kind kind;
  std::string_view name;
  std::string_view class_name;
  SizeRange size;
  void (*build)(Random&, Solids&);
};

const std::array<KindEntry, kKinds.size()>& Table() {
  static const std::array<KindEntry, kKinds.size()> table = {{
      {Kind::kChair, "chair", "chair", {{0.34, 0.34, 0.55}, {0.85, 0.8, 1.2}}, BuildChair},
      {Kind::kStool, "stool", "chair", {{0.2, 0.25, 0.36}, {0.7, 0.7, 0.82}}, BuildStool},
      {Kind::kOfficeChair,
       "office_chair",
       "chair",
       {{0.45, 0.45, 0.6}, {0.85, 0.85, 1.3}},
       BuildOfficeChair},
      {Kind::kArmchair,
       "armchair",
       "chair",
       {{0.55, 0.55, 0.6}, {1.05, 1.05, 1.15}},
       BuildArmchair},
      {Kind::kShellChair,
       "shell_chair",
       "chair",
       {{0.4, 0.38, 0.6}, {1.15, 0.85, 1.15}},
       BuildShellChair},
      {Kind::kTable, "table", "table", {{0.34, 0.4, 0.3}, {1.2, 2.1, 0.82}}, BuildTable},
      {Kind::kRoundTable,
       "round_table",
       "table",
       {{0.36, 0.38, 0.3}, {1.5, 1.5, 0.82}},
       BuildRoundTable},
      {Kind::kDesk, "desk", "table", {{0.42, 0.85, 0.6}, {1.0, 2.0, 1.25}}, BuildDesk},
      {Kind::kSofa, "sofa", "sofa", {{0.7, 0.7, 0.58}, {2.1, 3.5, 1.15}}, BuildSofa},
      {Kind::kCornerSofa,
       "corner_sofa",
       "sofa",
       {{1.05, 1.2, 0.58}, {3.2, 3.6, 1.15}},
       BuildCornerSofa},
      {Kind::kSettee, "settee", "sofa", {{0.42, 0.9, 0.5}, {1.2, 2.5, 1.15}}, BuildSettee},
      {Kind::kFramedSofa,
       "framed_sofa",
       "sofa",
       {{0.5, 0.5, 0.5}, {1.3, 3.2, 1.15}},
       BuildFramedSofa},
      {Kind::kBed, "bed", "bed", {{1.7, 0.78, 0.28}, {2.45, 2.15, 1.6}}, BuildBed},
      {Kind::kCabinet, "cabinet", "cabinet", {{0.28, 0.3, 0.34}, {0.75, 2.1, 2.4}}, BuildCabinet},
      {Kind::kShelf, "shelf", "shelf", {{0.18, 0.28, 0.45}, {0.65, 2.9, 2.4}}, BuildShelf},
  }};
  return table;
}

const KindEntry& Entry(Kind kind) { return Table().at(static_cast<std::size_t>(kind)); }

// Box of the mesh to the origin; sides beyond the range are brought to it.
void Settle(const SizeRange& range, Design& design) {
  Eigen::Vector3f low = design.mesh.vertices.front();
  Eigen::Vector3f high = low;
  for (const Eigen::Vector3f& vertex : design.mesh.vertices) {
    low = low.cwiseMin(vertex);
    high = high.cwiseMax(vertex);
  }
  const Eigen::Vector3d extent = (high - low).cast<double>();
  DEEPSLAM_CHECK(extent.minCoeff() > 0, "a design with no extent");
  design.size_m = extent.cwiseMax(range.min_m).cwiseMin(range.max_m);
  const Eigen::Vector3f factor = (design.size_m.array() / extent.array()).cast<float>();
  const Eigen::Vector3f middle = 0.5F * (low + high);
  for (Eigen::Vector3f& vertex : design.mesh.vertices)
    vertex = (vertex - middle).cwiseProduct(factor);
}

constexpr std::array kChairKinds = {KindShare{Kind::kChair, 0.52},
                                    KindShare{Kind::kOfficeChair, 0.14},
                                    KindShare{Kind::kArmchair, 0.12},
                                    KindShare{Kind::kShellChair, 0.12},
                                    KindShare{Kind::kStool, 0.10}};
constexpr std::array kTableKinds = {
    KindShare{Kind::kTable, 0.55}, KindShare{Kind::kRoundTable, 0.25}, KindShare{Kind::kDesk, 0.2}};
constexpr std::array kSofaKinds = {KindShare{Kind::kSofa, 0.45},
                                   KindShare{Kind::kCornerSofa, 0.13},
                                   KindShare{Kind::kSettee, 0.17},
                                   KindShare{Kind::kFramedSofa, 0.25}};
constexpr std::array kBedKinds = {KindShare{Kind::kBed, 1.0}};
constexpr std::array kCabinetKinds = {KindShare{Kind::kCabinet, 1.0}};
constexpr std::array kShelfKinds = {KindShare{Kind::kShelf, 1.0}};

}  // namespace

std::string_view KindName(Kind kind) { return Entry(kind).name; }
std::string_view ClassName(Kind kind) { return Entry(kind).class_name; }
SizeRange SizeRangeOf(Kind kind) { return Entry(kind).size; }

std::span<const KindShare> KindsOfClass(std::string_view class_name) {
  for (const std::span<const KindShare> kinds : {std::span<const KindShare>(kChairKinds),
                                                 std::span<const KindShare>(kTableKinds),
                                                 std::span<const KindShare>(kSofaKinds),
                                                 std::span<const KindShare>(kBedKinds),
                                                 std::span<const KindShare>(kCabinetKinds),
                                                 std::span<const KindShare>(kShelfKinds)}) {
    if (ClassName(kinds.front().kind) == class_name) return kinds;
  }
  return {};
}

Design MakeDesign(Kind kind, Random random) {
  Solids solids;
  Entry(kind).build(random, solids);
  Design design{kind, solids.mesh(), solids.material_of_face(), solids.first_faces(), {}};
  Settle(Entry(kind).size, design);
  return design;
}

}  // namespace deepslam::furniture
