#include "deepslam/usd/usda_text.h"

#include <array>
#include <charconv>
#include <cmath>

#include "deepslam/core/utf8.h"

namespace deepslam::usd {
namespace {

constexpr int kDecimals = 5;  // 10 um where units are metres: finer than any measured surface

template <typename Values, typename Append>
void AppendList(const Values& values, std::string& text, const Append& append) {
  text += '[';
  bool first = true;
  for (const auto& value : values) {
    if (!first) text += ", ";
    first = false;
    append(value);
  }
  text += ']';
}

void AppendInt(std::uint32_t value, std::string& text) {
  std::array<char, 16> digits;
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  text.append(digits.data(), end);
}

std::array<Eigen::Vector3d, 256> LinearSteps() {
  std::array<Eigen::Vector3d, 256> steps;
  for (std::size_t n = 0; n < steps.size(); ++n) {
    const double share = static_cast<double>(n) / 255;
    const double linear = share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
    steps[n] = Eigen::Vector3d::Constant(linear);
  }
  return steps;
}

}  // namespace

void AppendNumber(double value, std::string& text) {
  std::array<char, 400> digits;  // the largest double has 309 before its point
  auto [end, error] = std::to_chars(
      digits.data(), digits.data() + digits.size(), value, std::chars_format::fixed, kDecimals);
  while (end[-1] == '0') --end;
  if (end[-1] == '.') --end;
  const std::string_view number(digits.data(), static_cast<std::size_t>(end - digits.data()));
  text += number == "-0" ? "0" : number;
}

void AppendVector(const Eigen::Vector3d& value, std::string& text) {
  text += '(';
  AppendNumber(value.x(), text);
  text += ", ";
  AppendNumber(value.y(), text);
  text += ", ";
  AppendNumber(value.z(), text);
  text += ')';
}

void AppendPoints(std::span<const Eigen::Vector3f> points, std::string& text) {
  AppendList(points, text, [&](const Eigen::Vector3f& p) { AppendVector(p.cast<double>(), text); });
}

void AppendCorners(const TriangleMesh& mesh, std::string& text) {
  AppendList(mesh.faces, text, [&](const std::array<std::uint32_t, 3>& face) {
    AppendInt(face[0], text);
    text += ", ";
    AppendInt(face[1], text);
    text += ", ";
    AppendInt(face[2], text);
  });
}

void AppendCounts(std::size_t num_faces, std::string& text) {
  text += '[';
  for (std::size_t n = 0; n < num_faces; ++n) text += n == 0 ? "3" : ", 3";
  text += ']';
}

Eigen::Vector3d LinearOf(Rgb8 srgb) {
  static const std::array<Eigen::Vector3d, 256> steps = LinearSteps();
  return {steps[srgb.r].x(), steps[srgb.g].x(), steps[srgb.b].x()};
}

void AppendColours(std::span<const Rgb8> srgb, std::string& text) {
  AppendList(srgb, text, [&](const Rgb8& colour) { AppendVector(LinearOf(colour), text); });
}

std::string Quoted(std::string_view value) {
  std::string quoted = "\"";
  for (const char c : ToValidUtf8(value)) {
    if (c == '"' || c == '\\') quoted += '\\';
    if (c == '\n') {
      quoted += "\\n";
    } else if (static_cast<unsigned char>(c) < 0x20) {
      quoted += ' ';  // other control characters end the text for some readers
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

}  // namespace deepslam::usd
