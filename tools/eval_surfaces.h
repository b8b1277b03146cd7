// Points of the surfaces that are compared: of all true objects, of all mapped ones.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "deepslam/artifact/json_value.h"
#include "eval_data.h"

namespace deepslam::tools {

inline constexpr double kAreaPerPointM2 = 25e-6;  // a point every 5 mm
inline constexpr double kTrueFloorBandM =
    0.03;  // points this near to the true floor belong to no side

void DropFloor(std::vector<Eigen::Vector3d>& points);
// Of the outer surfaces, true world.
[[nodiscard]] std::vector<Eigen::Vector3d> TruePoints(const Truth& truth);
[[nodiscard]] std::vector<Eigen::Vector3d> MapPoints(const MapResult& map);

// Every object of it has a shape, not a box alone.
[[nodiscard]] bool HasSurfaces(const Truth& truth);

// The comparisons that object mappers publish, at 1, 2 and 5 cm; the shares of true surface within
// 5 cm and 1 cm are the completion ratios of vMAP (Kong et al. 2023).
struct SurfaceFigures {
  double threshold_m = 0;
  eval::SurfaceComparison surface;
};
[[nodiscard]] std::vector<SurfaceFigures> CompareObjectSurfaces(const MapResult& map,
                                                                const Truth& truth);
[[nodiscard]] artifact::JsonValue ToJson(const std::vector<SurfaceFigures>& figures);
// To stderr.
void Print(const std::vector<SurfaceFigures>& figures);

}  // namespace deepslam::tools
