// A drawing as DXF of AutoCAD's release 12 in ASCII, which every CAD program reads: layers, lines,
// outlines, arcs and texts. Units are metres, angles degrees counter-clockwise from x.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace deepslam::report {

enum class DxfLine { kContinuous, kDashed };

struct DxfLayer {
  std::string_view name;  // capitals, as release 12 has them
  int colour = 7;         // AutoCAD's index; 7: black, or white on a black screen
};

class DxfText {
 public:
  explicit DxfText(std::span<const DxfLayer> layers);

  void AddLine(std::string_view layer,
               const Eigen::Vector2d& from_m,
               const Eigen::Vector2d& to_m,
               DxfLine line = DxfLine::kContinuous);
  void AddOutline(std::string_view layer, std::span<const Eigen::Vector2d> corners_m);  // closed
  // A quarter or whatever of a circle, counter-clockwise from `from_m` to the direction of `to_m`.
  void AddArc(std::string_view layer,
              const Eigen::Vector2d& centre_m,
              const Eigen::Vector2d& from_m,
              const Eigen::Vector2d& to_m);
  // Centred on `middle_m`. Characters that are not printable ASCII become question marks: release
  // 12 knows no others.
  void AddText(std::string_view layer,
               const Eigen::Vector2d& middle_m,
               double height_m,
               double angle_deg,
               std::string_view text);

  // The whole file; all that was added so far. Its extents are those of what was added.
  [[nodiscard]] std::string Finish() const;

 private:
  void Begin(std::string_view entity, std::string_view layer);
  void Place(int group, const Eigen::Vector2d& p_m);  // and makes room for it

  std::vector<DxfLayer> layers_;
  std::string entities_;
  Eigen::Vector2d low_m_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d high_m_ = Eigen::Vector2d::Zero();
  bool is_empty_ = true;
};

}  // namespace deepslam::report
