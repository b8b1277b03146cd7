// Values as URDF, MJCF and SDF have them.
#pragma once

#include <string>
#include <string_view>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace deepslam::simulator {

// Of attributes and comments: markup escaped, control characters blanks, no two hyphens in a row.
[[nodiscard]] std::string XmlText(std::string_view text);
// "1 0 0.25", six decimals at most.
[[nodiscard]] std::string Numbers(const Eigen::Vector3d& value);
// "w x y z".
[[nodiscard]] std::string WxyzOf(const Eigen::Quaterniond& rotation);
// Roll, pitch and yaw about the fixed axes x, y, z, as URDF and SDF turn things, rad.
[[nodiscard]] Eigen::Vector3d RollPitchYaw(const Eigen::Quaterniond& rotation);

}  // namespace deepslam::simulator
