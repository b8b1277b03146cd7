// Values as .usda has them, appended to a text.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "deepslam/core/image.h"
#include "deepslam/scene/triangle_mesh.h"

namespace deepslam::usd {

// At most five decimals, none of them a zero at the end.
void AppendNumber(double value, std::string& text);
void AppendVector(const Eigen::Vector3d& value, std::string& text);             // (x, y, z)
void AppendPoints(std::span<const Eigen::Vector3f> points, std::string& text);  // [(..), ..]
void AppendCorners(const TriangleMesh& mesh, std::string& text);                // [0, 1, 2, ..]
void AppendCounts(std::size_t num_faces, std::string& text);                    // [3, 3, ..]
// Of a colour of images to the linear one that USD shades with.
[[nodiscard]] Eigen::Vector3d LinearOf(Rgb8 srgb);
void AppendColours(std::span<const Rgb8> srgb, std::string& text);  // [(..), ..], linear
// In quotes; line breaks and quotes escaped, valid UTF-8 whatever comes in.
[[nodiscard]] std::string Quoted(std::string_view value);

}  // namespace deepslam::usd
