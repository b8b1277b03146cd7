#include "deepslam/report/dxf_text.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "deepslam/core/angles.h"

namespace deepslam::report {
namespace {

// Group codes of the DXF reference, release 12.
constexpr int kEntity = 0;
constexpr int kValue = 1;         // text of an entity or a variable
constexpr int kName = 2;          // of a table's entry or a section
constexpr int kLineType = 6;      // its name in the table LTYPE
constexpr int kTextStyle = 7;     // its name in the table STYLE
constexpr int kLayer = 8;         // its name in the table LAYER
constexpr int kVariable = 9;      // name of one of the header
constexpr int kPoint = 10;        // x; y is at 20, z at 30
constexpr int kSecondPoint = 11;  // y is at 21

std::string Group(int code, std::string_view value) {
  return fmt::format("{:3}\n{}\n", code, value);
}
std::string Group(int code, int value) { return fmt::format("{:3}\n{:6}\n", code, value); }
// To a tenth of a millimetre; never -0.
std::string Group(int code, double value) {
  return fmt::format("{:3}\n{:.4f}\n", code, std::round(value * 1e4) / 1e4 + 0.0);
}

std::string Table(std::string_view name, int count, std::string_view entries) {
  return Group(kEntity, "TABLE") + Group(kName, name) + Group(70, count) + std::string(entries) +
         Group(kEntity, "ENDTAB");
}

// Dashes of 25 cm with gaps of half of that: to be seen in a plan of a room and in one of a house.
std::string LineTypes() {
  const auto type =
      [](std::string_view name, std::string_view shown, int num_dashes, double length_m) {
        return Group(kEntity, "LTYPE") + Group(kName, name) + Group(70, 0) + Group(3, shown) +
               Group(72, 65) + Group(73, num_dashes) + Group(40, length_m);
      };
  return type("CONTINUOUS", "Solid line", 0, 0) + type("DASHED", "__ __ __", 2, 0.375) +
         Group(49, 0.25) + Group(49, -0.125);
}

std::string Styles() {
  return Group(kEntity, "STYLE") + Group(kName, "STANDARD") + Group(70, 0) + Group(40, 0.0) +
         Group(41, 1.0) + Group(50, 0.0) + Group(71, 0) + Group(42, 0.2) + Group(3, "txt") +
         Group(4, "");
}

std::string Printable(std::string_view text) {
  std::string printable;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    // Of a character of several bytes the first one stands for it.
    if ((byte & 0xC0U) == 0x80U) continue;
    printable += byte >= 0x20 && byte < 0x7F ? c : '?';
  }
  return printable;
}

double AngleDeg(const Eigen::Vector2d& direction) {
  const double angle = std::atan2(direction.y(), direction.x()) * kDegPerRad;
  return angle < 0 ? angle + 360 : angle;
}

}  // namespace

DxfText::DxfText(std::span<const DxfLayer> layers) : layers_(layers.begin(), layers.end()) {}

void DxfText::Begin(std::string_view entity, std::string_view layer) {
  entities_ += Group(kEntity, entity) + Group(kLayer, layer);
}

void DxfText::Place(int group, const Eigen::Vector2d& p_m) {
  low_m_ = is_empty_ ? p_m : Eigen::Vector2d(low_m_.cwiseMin(p_m));
  high_m_ = is_empty_ ? p_m : Eigen::Vector2d(high_m_.cwiseMax(p_m));
  is_empty_ = false;
  entities_ += Group(group, p_m.x()) + Group(group + 10, p_m.y()) + Group(group + 20, 0.0);
}

void DxfText::AddLine(std::string_view layer,
                      const Eigen::Vector2d& from_m,
                      const Eigen::Vector2d& to_m,
                      DxfLine line) {
  Begin("LINE", layer);
  if (line == DxfLine::kDashed) entities_ += Group(kLineType, "DASHED");
  Place(kPoint, from_m);
  Place(kSecondPoint, to_m);
}

void DxfText::AddOutline(std::string_view layer, std::span<const Eigen::Vector2d> corners_m) {
  Begin("POLYLINE", layer);
  entities_ += Group(66, 1) + Group(kPoint, 0.0) + Group(kPoint + 10, 0.0) +
               Group(kPoint + 20, 0.0) + Group(70, 1);
  for (const Eigen::Vector2d& corner : corners_m) {
    Begin("VERTEX", layer);
    Place(kPoint, corner);
  }
  Begin("SEQEND", layer);
}

void DxfText::AddArc(std::string_view layer,
                     const Eigen::Vector2d& centre_m,
                     const Eigen::Vector2d& from_m,
                     const Eigen::Vector2d& to_m) {
  Begin("ARC", layer);
  Place(kPoint, centre_m);
  entities_ += Group(40, (from_m - centre_m).norm()) + Group(50, AngleDeg(from_m - centre_m)) +
               Group(51, AngleDeg(to_m - centre_m));
}

void DxfText::AddText(std::string_view layer,
                      const Eigen::Vector2d& middle_m,
                      double height_m,
                      double angle_deg,
                      std::string_view text) {
  Begin("TEXT", layer);
  Place(kPoint, middle_m);
  entities_ += Group(40, height_m) + Group(kValue, Printable(text)) + Group(50, angle_deg) +
               Group(kTextStyle, "STANDARD") + Group(72, 1);
  Place(kSecondPoint, middle_m);
  entities_ += Group(73, 2);
}

std::string DxfText::Finish() const {
  const auto corner = [](std::string_view name, const Eigen::Vector2d& p_m) {
    return Group(kVariable, name) + Group(kPoint, p_m.x()) + Group(kPoint + 10, p_m.y()) +
           Group(kPoint + 20, 0.0);
  };
  std::string layers;
  for (const DxfLayer& layer : layers_) {
    layers += Group(kEntity, "LAYER") + Group(kName, layer.name) + Group(70, 0) +
              Group(62, layer.colour) + Group(kLineType, "CONTINUOUS");
  }
  constexpr int kMetres = 6;  // of $INSUNITS
  const auto section = [](std::string_view name, const std::string& content) {
    return Group(kEntity, "SECTION") + Group(kName, name) + content + Group(kEntity, "ENDSEC");
  };
  return section("HEADER",
                 Group(kVariable, "$ACADVER") + Group(kValue, "AC1009") +
                     Group(kVariable, "$INSUNITS") + Group(70, kMetres) +
                     corner("$EXTMIN", low_m_) + corner("$EXTMAX", high_m_)) +
         section("TABLES",
                 Table("LTYPE", 2, LineTypes()) +
                     Table("LAYER", static_cast<int>(layers_.size()), layers) +
                     Table("STYLE", 1, Styles())) +
         section("ENTITIES", entities_) + Group(kEntity, "EOF");
}

}  // namespace deepslam::report
