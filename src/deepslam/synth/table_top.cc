#include "deepslam/synth/table_top.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "deepslam/geometry/box.h"

namespace deepslam::synth {
namespace {

constexpr double kTopCellM = 0.005;  // how well edges are known
// Boards of a top, and its rounded rim, differ by less.
constexpr double kTopThicknessM = 0.02;
// Gaps between the boards of one top are no edges.
constexpr int kGapCells = 3;
constexpr int kMaxSide = 4000;  // cells, 20 m: nothing is put on larger tops

// Marks cells whose middle lies in the face as seen from above.
void Fill(const std::array<Eigen::Vector2d, 3>& p, cv::Mat& top) {
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  const double area = cross(p[1] - p[0], p[2] - p[0]);
  if (std::abs(area) < 1e-9) return;
  const Eigen::Vector2d low = p[0].cwiseMin(p[1]).cwiseMin(p[2]);
  const Eigen::Vector2d high = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
  for (int y = std::max(0, static_cast<int>(low.y()));
       y <= std::min(top.rows - 1, static_cast<int>(high.y()));
       ++y) {
    for (int x = std::max(0, static_cast<int>(low.x()));
         x <= std::min(top.cols - 1, static_cast<int>(high.x()));
         ++x) {
      const Eigen::Vector2d q(x + 0.5, y + 0.5);
      const double a = cross(p[1] - p[0], q - p[0]) / area;
      const double b = cross(p[2] - p[1], q - p[1]) / area;
      const double c = cross(p[0] - p[2], q - p[2]) / area;
      if (std::min({a, b, c}) >= -1e-9) top.at<std::uint8_t>(y, x) = 255;
    }
  }
}

}  // namespace

TableTop::TableTop(const TriangleMesh& mesh_object) {
  Box3 box;
  for (const Eigen::Vector3f& v : mesh_object.vertices) box.Extend(v.cast<double>());
  if (box.empty()) return;
  top_m_ = box.max.z();
  const double border_m = 2 * kTopCellM;
  origin_m_ = box.min.head<2>().array() - border_m;
  const Eigen::Vector2i size =
      ((box.Size().head<2>().array() + 2 * border_m) / kTopCellM).ceil().cast<int>();
  if (size.maxCoeff() > kMaxSide) return;
  cv::Mat top = cv::Mat::zeros(size.y(), size.x(), CV_8UC1);
  for (const std::array<std::uint32_t, 3>& face : mesh_object.faces) {
    std::array<Eigen::Vector2d, 3> corners;
    double lowest = top_m_;
    for (std::size_t c = 0; c < 3; ++c) {
      const Eigen::Vector3d p = mesh_object.vertices[face[c]].cast<double>();
      corners[c] = (p.head<2>() - origin_m_) / kTopCellM;
      lowest = std::min(lowest, p.z());
    }
    if (lowest >= top_m_ - kTopThicknessM) Fill(corners, top);
  }
  cv::morphologyEx(
      top, top, cv::MORPH_CLOSE, cv::getStructuringElement(cv::MORPH_RECT, {kGapCells, kGapCells}));
  cv::Mat cells;
  cv::distanceTransform(top, cells, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  to_edge_m_ = Image<float>(size.x(), size.y());
  for (int y = 0; y < size.y(); ++y) {
    for (int x = 0; x < size.x(); ++x)
      to_edge_m_(x, y) = static_cast<float>(kTopCellM) * cells.at<float>(y, x);
  }
}

bool TableTop::Inside(const Eigen::Vector3d& p_object, double margin_m) const {
  if (p_object.z() < top_m_ - kTopThicknessM) return false;
  const Eigen::Vector2d cell = (p_object.head<2>() - origin_m_) / kTopCellM;
  const int x = static_cast<int>(std::floor(cell.x()));
  const int y = static_cast<int>(std::floor(cell.y()));
  return to_edge_m_.Contains(x, y) && static_cast<double>(to_edge_m_(x, y)) > margin_m;
}

}  // namespace deepslam::synth
