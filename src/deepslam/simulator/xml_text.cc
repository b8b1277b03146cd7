#include "deepslam/simulator/xml_text.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "deepslam/core/utf8.h"

namespace deepslam::simulator {

std::string XmlText(std::string_view text) {
  std::string out;
  for (const char c : ToValidUtf8(text)) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '-':
        out += !out.empty() && out.back() == '-' ? " -" : "-";
        break;
      default:
        out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return out;
}

std::string Numbers(const Eigen::Vector3d& value) {
  const auto rounded = [](double v) { return std::round(v * 1e6) / 1e6 + 0.0; };  // no minus zero
  return fmt::format("{} {} {}", rounded(value.x()), rounded(value.y()), rounded(value.z()));
}

std::string WxyzOf(const Eigen::Quaterniond& rotation) {
  const Eigen::Quaterniond q = rotation.normalized();
  return fmt::format("{:.9g} {:.9g} {:.9g} {:.9g}", q.w(), q.x(), q.y(), q.z());
}

Eigen::Vector3d RollPitchYaw(const Eigen::Quaterniond& rotation) {
  const Eigen::Matrix3d m = rotation.normalized().toRotationMatrix();
  const double pitch = std::asin(std::clamp(-m(2, 0), -1.0, 1.0));
  constexpr double kGimbalLock = 0.999999;  // roll and yaw turn about one axis
  if (std::abs(m(2, 0)) > kGimbalLock) return {0, pitch, std::atan2(-m(0, 1), m(1, 1))};
  return {std::atan2(m(2, 1), m(2, 2)), pitch, std::atan2(m(1, 0), m(0, 0))};
}

}  // namespace deepslam::simulator
