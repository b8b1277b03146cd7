#include "eval_surfaces.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

namespace deepslam::tools {

void DropFloor(std::vector<Eigen::Vector3d>& points) {
  std::erase_if(points, [](const Eigen::Vector3d& p) { return p.z() < kTrueFloorBandM; });
}

std::vector<Eigen::Vector3d> TruePoints(const Truth& truth) {
  std::vector<Eigen::Vector3d> all;
  for (std::size_t i = 0; i < truth.objects.size(); ++i) {
    const TrueObject& object = truth.objects[i];
    const std::vector<Eigen::Vector3d> sampled =
        eval::SampleSurface(object.mesh, {}, kAreaPerPointM2, i + 1);
    for (const Eigen::Vector3d& p : eval::OuterPoints(object.mesh, sampled))
      all.push_back(object.box.world_from_object * p);
  }
  DropFloor(all);
  return all;
}

std::vector<Eigen::Vector3d> MapPoints(const MapResult& map) {
  std::vector<Eigen::Vector3d> all;
  for (std::size_t i = 0; i < map.objects.size(); ++i) {
    const MappedObject& object = map.objects[i];
    const std::vector<Eigen::Vector3d> points =
        eval::SampleSurface(object.mesh, object.true_world_from_object, kAreaPerPointM2, i + 1);
    all.insert(all.end(), points.begin(), points.end());
  }
  DropFloor(all);
  return all;
}

bool HasSurfaces(const Truth& truth) {
  return std::ranges::all_of(truth.objects, &TrueObject::has_shape);
}

std::vector<SurfaceFigures> CompareObjectSurfaces(const MapResult& map, const Truth& truth) {
  constexpr std::array<double, 3> kThresholdsM = {0.01, 0.02, 0.05};
  const std::vector<Eigen::Vector3d> ours = MapPoints(map);
  const std::vector<Eigen::Vector3d> true_points = TruePoints(truth);
  std::vector<SurfaceFigures> figures;
  for (const double threshold_m : kThresholdsM)
    figures.push_back({threshold_m, eval::CompareSurfaces(ours, true_points, threshold_m)});
  return figures;
}

artifact::JsonValue ToJson(const std::vector<SurfaceFigures>& figures) {
  artifact::JsonArray rows;
  for (const SurfaceFigures& at : figures) {
    artifact::JsonObject row;
    row.emplace("threshold_m", at.threshold_m);
    row.emplace("surface", ToJson(at.surface));
    rows.emplace_back(std::move(row));
  }
  return artifact::JsonValue(std::move(rows));
}

void Print(const std::vector<SurfaceFigures>& figures) {
  for (const SurfaceFigures& at : figures) {
    fmt::print(stderr,
               "surfaces at {:.0f} cm: F {:.1f} %, complete {:.1f} %, accurate {:.1f} %\n",
               100 * at.threshold_m,
               100 * at.surface.f_score,
               100 * at.surface.completeness,
               100 * at.surface.accuracy);
  }
}

}  // namespace deepslam::tools
