#include "deepslam/formats/pose_matrix.h"

#include <cmath>

#include <fmt/format.h>

#include "deepslam/geometry/max_position.h"

namespace deepslam::formats {
namespace {

constexpr double kRotationTolerance = 0.01;  // of an entry: files written with two decimals pass

}  // namespace

std::optional<Pose3> PoseOfMatrix(std::span<const double, 16> row_major) {
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) matrix(i / 4, i % 4) = row_major[static_cast<std::size_t>(i)];
  if (!matrix.allFinite()) return std::nullopt;
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const Eigen::Matrix3d square = rotation.transpose() * rotation;
  if ((square - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 2 * kRotationTolerance)
    return std::nullopt;
  if (rotation.determinant() < 0) return std::nullopt;
  const Eigen::Vector3d position_m = matrix.topRightCorner<3, 1>();
  if (position_m.cwiseAbs().maxCoeff() > kMaxPositionM) return std::nullopt;
  return Pose3{Eigen::Quaterniond(rotation).normalized(), position_m};
}

std::string FormatMatrix(const Pose3& b_from_a) {
  const Eigen::Matrix4d matrix = b_from_a.Matrix();
  std::string text;
  for (int row = 0; row < 4; ++row) {
    text += fmt::format(
        "{} {} {} {}\n", matrix(row, 0), matrix(row, 1), matrix(row, 2), matrix(row, 3));
  }
  return text;
}

}  // namespace deepslam::formats
