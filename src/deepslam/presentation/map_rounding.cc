#include "deepslam/presentation/map_rounding.h"

#include <cmath>
#include <utility>
#include <vector>

#include "deepslam/mesh/ground_polygon.h"

namespace deepslam::presentation {
namespace {

double RoundedTo(double value, double step) {
  // The inverse is a whole number, so that the result has as few digits as its shortest text.
  const double inverse = std::round(1.0 / step);
  return std::round(value * inverse) / inverse;
}

}  // namespace

TriangleMesh RoundedGround(const TriangleMesh& ground_polygon) {
  const std::vector<Eigen::Vector2d> outline = mesh::OutlineOf(ground_polygon);
  for (const double step_m : {kMapOutlineStepM, kMapPlaceStepM}) {
    std::vector<Eigen::Vector2d> rounded;
    for (const Eigen::Vector2d& p : outline) {
      const Eigen::Vector2d q = {RoundedTo(p.x(), step_m), RoundedTo(p.y(), step_m)};
      if (rounded.empty() || q != rounded.back()) rounded.push_back(q);
    }
    if (rounded.size() > 1 && rounded.front() == rounded.back()) rounded.pop_back();
    Result<TriangleMesh> mesh = mesh::TriangulateOutline(rounded);
    if (mesh.ok()) return std::move(mesh).value();
  }
  return ground_polygon;
}

namespace {

void Round(Eigen::Vector2d& p) {
  p = p.unaryExpr([](double value) { return RoundedTo(value, kMapLayoutStepM); });
}

template <typename Part>
void RoundPart(Part& part) {
  Round(part.from_m);
  Round(part.to_m);
  part.bottom_m = RoundedTo(part.bottom_m, kMapLayoutStepM);
  part.top_m = RoundedTo(part.top_m, kMapLayoutStepM);
  part.confidence = RoundedTo(part.confidence, kMapShareStep);
}

void Round(CompactLayout& layout) {
  for (CompactRoom& room : layout.rooms) {
    for (Eigen::Vector2d& p : room.polygon_m) Round(p);
    room.floor_m = RoundedTo(room.floor_m, kMapLayoutStepM);
    if (room.ceiling_m) room.ceiling_m = RoundedTo(*room.ceiling_m, kMapLayoutStepM);
  }
  for (CompactWall& wall : layout.walls) {
    RoundPart(wall);
    wall.seen_share = RoundedTo(wall.seen_share, kMapShareStep);
  }
  for (CompactOpening& opening : layout.openings) RoundPart(opening);
}

}  // namespace

CompactMap Rounded(CompactMap map) {
  if (map.layout) Round(*map.layout);
  for (Eigen::Vector2d& p : map.ground_outline_m) {
    p = p.unaryExpr([](double value) { return RoundedTo(value, kMapPlaceStepM); });
  }
  for (CompactObject& entry : map.objects) {
    Pose3& pose = entry.world_from_object;
    pose.rotation.coeffs() = pose.rotation.normalized().coeffs().unaryExpr(
        [](double value) { return RoundedTo(value, kMapRotationStep); });
    pose.translation_m =
        pose.translation_m.unaryExpr([](double value) { return RoundedTo(value, kMapPlaceStepM); });
    entry.scale_m = RoundedTo(entry.scale_m, kMapScaleStepM);
    entry.size_m =
        entry.size_m.unaryExpr([](double value) { return RoundedTo(value, kMapPlaceStepM); });
    entry.confidence = RoundedTo(entry.confidence, kMapScoreStep);
  }
  return map;
}

}  // namespace deepslam::presentation
