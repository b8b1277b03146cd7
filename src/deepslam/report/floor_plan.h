// The floor plan of a map as SVG, as architects draw one: walls with their thickness, doors with
// the arc of their leaf, windows as double lines, furniture as outlines with names and measures.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "deepslam/core/image.h"
#include "deepslam/geometry/pose.h"
#include "deepslam/scene/layout.h"

namespace deepslam::report {

// World: z up, metres.
struct PlanThing {
  std::string name;
  std::array<Eigen::Vector2d, 4> corners_m;          // of its footprint, the front side first
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // depth, width, height
  Rgb8 colour;
};

[[nodiscard]] PlanThing MakePlanThing(const std::string& name,
                                      const Pose3& world_from_object,
                                      const Eigen::Vector3d& size_m,
                                      Rgb8 colour);

struct FloorPlanContent {
  std::string title;
  Layout layout_world;
  std::vector<PlanThing> things;
  std::vector<Eigen::Vector2d> others_m;  // places that have to be on it as well
};

// World metres to the drawing's pixels: turned so that most of the walls run along its sides, by 45
// degrees at most; y grows upwards in the world and downwards in the drawing.
class PlanCanvas {
 public:
  explicit PlanCanvas(const FloorPlanContent& content);

  [[nodiscard]] Eigen::Vector2d ToPixels(const Eigen::Vector2d& p_m) const;
  // A direction as the drawing has it, y down.
  [[nodiscard]] Eigen::Vector2d Turned(const Eigen::Vector2d& direction) const;
  [[nodiscard]] double width_px() const { return width_px_; }
  [[nodiscard]] double height_px() const { return height_px_; }
  // Of rooms and walls, which overall measures are of; of all that is drawn where there are none.
  [[nodiscard]] Eigen::Vector2d min_px() const { return min_px_; }
  [[nodiscard]] Eigen::Vector2d max_px() const { return max_px_; }

 private:
  Eigen::Matrix2d turn_ = Eigen::Matrix2d::Identity();
  Eigen::Vector2d low_m_ = Eigen::Vector2d::Zero();  // of all that is drawn, turned
  Eigen::Vector2d high_m_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d min_px_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d max_px_ = Eigen::Vector2d::Zero();
  double width_px_ = 0;
  double height_px_ = 0;
};

inline constexpr double kPlanPixelsPerMetre = 100;  // a pixel is a centimetre

// `draw_over` draws over the furniture, below the names. Same content, same text. A layout without
// walls is a plan of the furniture alone.
[[nodiscard]] std::string FloorPlan(
    const FloorPlanContent& content,
    const std::function<std::string(const PlanCanvas&)>& draw_over = {});

}  // namespace deepslam::report
