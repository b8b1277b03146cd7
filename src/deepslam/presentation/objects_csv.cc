#include "deepslam/presentation/objects_csv.h"

#include <cmath>

#include <fmt/format.h>

#include "deepslam/core/angles.h"
#include "deepslam/core/check.h"

namespace deepslam::presentation {
namespace {

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  if (!text.empty() && std::string_view("=+-@").find(text.front()) != std::string_view::npos)
    quoted += '\'';
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

}  // namespace

std::string EncodeObjectsCsv(std::span<const CompactObject> objects,
                             std::span<const double> volumes_m3) {
  DEEPSLAM_CHECK(objects.size() == volumes_m3.size(), "one volume per object");
  std::string text =
      "name,class,depth_m,width_m,height_m,volume_m3,x_m,y_m,z_m,heading_deg,confidence,source,"
      "credit,note\n";
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const CompactObject& entry = objects[i];
    const Eigen::Vector3d front = entry.world_from_object.rotation * Eigen::Vector3d::UnitX();
    const Eigen::Vector3d& t = entry.world_from_object.translation_m;
    text += fmt::format(
        "{},{},{:.3f},{:.3f},{:.3f},{:.4f},{:.3f},{:.3f},{:.3f},{:.1f},{:.3f},{},{},{}\n",
        Quoted(entry.name),
        Quoted(entry.class_name),
        entry.size_m.x(),
        entry.size_m.y(),
        entry.size_m.z(),
        volumes_m3[i],
        t.x(),
        t.y(),
        t.z(),
        std::atan2(front.y(), front.x()) * kDegPerRad,
        entry.confidence,
        NameOf(entry.source),
        Quoted(entry.credit),
        Quoted(entry.note));
  }
  return text;
}

}  // namespace deepslam::presentation
