#include "deepslam/report/viewer_section.h"

#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "deepslam/core/base64.h"
#include "deepslam/report/explain.h"
#include "deepslam/report/html.h"
#include "deepslam/report/viewer_bundle.h"

namespace deepslam::report {
namespace {

using Json = nlohmann::json;

// Beyond this browsers take long to open a page; the scene is better opened as the file it is.
constexpr std::size_t kMaxSceneBytes = 24u << 20;
constexpr std::size_t kMaxPathPoints = 2000;  // more would look the same and make the page larger

double Rounded(double value) {
  const double rounded = std::round(value * 1e4) / 1e4;
  return std::isfinite(rounded) ? rounded + 0.0 : 0.0;
}

Json Vector(const Eigen::Vector3d& v) { return {Rounded(v.x()), Rounded(v.y()), Rounded(v.z())}; }

Json Points(std::span<const Eigen::Vector3f> points) {
  constexpr float kMax_m = 65.0f;  // what 16 bits of millimetres hold
  Eigen::Vector3f origin = points.front();
  for (const Eigen::Vector3f& p : points) origin = origin.cwiseMin(p);
  std::string bytes;
  bytes.reserve(points.size() * 6);
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector3f above = (p - origin).cwiseMin(kMax_m);
    for (int c = 0; c < 3; ++c) {
      const auto mm = static_cast<unsigned>(std::lround(above[c] * 1000.0f));
      bytes += static_cast<char>(mm & 0xFF);
      bytes += static_cast<char>(mm >> 8 & 0xFF);
    }
  }
  return {{"origin_m", Vector(origin.cast<double>())}, {"data", EncodeBase64(bytes)}};
}

Json Candidate(const CandidateRow& row) {
  return {{"model", row.model},
          {"source", row.source},
          {"score", Rounded(row.score)},
          {"surface", Rounded(row.surface_share)},
          {"coverage", Rounded(row.coverage_share)},
          {"free", Rounded(row.free_violation)},
          {"views", row.num_views},
          {"chosen", row.chosen}};
}

Json Object(const ObjectRow& object) {
  Json json = {{"name", object.name},
               {"class", object.class_name},
               {"colour", {object.colour.r, object.colour.g, object.colour.b}},
               {"confidence", Rounded(object.confidence)},
               {"views", object.num_views},
               {"size_m", Vector(object.size_m)},
               {"source", object.source},
               {"credit", object.credit},
               {"note", object.note},
               {"why", WhyItWon(object)},
               {"candidates", Json::array()}};
  for (const CandidateRow& row : object.candidates) json["candidates"].push_back(Candidate(row));
  if (!object.measured_world.empty()) json["points"] = Points(object.measured_world);
  return json;
}

// At most kMaxPathPoints of the path, evenly.
template <typename PositionAt>
Json Path(std::size_t count, const PositionAt& position_at) {
  Json path = Json::array();
  const std::size_t step = count / kMaxPathPoints + 1;
  for (std::size_t i = 0; i < count; i += step) path.push_back(Vector(position_at(i)));
  return path;
}

bool HasView(const ReportContent& content) {
  return !ViewerBundle().empty() && !content.scene_glb.empty() &&
         content.scene_glb.size() <= kMaxSceneBytes;
}

std::string WhyNoView(const ReportContent& content) {
  if (content.scene_glb.empty()) return "There is no scene to show.";
  if (ViewerBundle().empty()) {
    return "This deepslam was built without the 3D view (three.js was not there: scripts/setup.sh "
           "fetches it). export/scene.glb opens in Blender and other programs.";
  }
  return "The scene is too large for a page; export/scene.glb opens in Blender and other programs.";
}

std::string Toggle(std::string_view layer, std::string_view text, bool on) {
  return fmt::format(
      "<label><input type=checkbox data-layer={}{}> {}</label>", layer, on ? " checked" : "", text);
}

std::string ObjectList(const ReportContent& content) {
  std::string html = "<div class=viewer-list role=group aria-label='objects'>";
  for (const ObjectRow& object : content.objects) {
    html += fmt::format(
        "<button type=button data-object='{0}' aria-pressed=false><span class=swatch "
        "style='background:rgb({1},{2},{3})'></span>{0}</button>",
        EscapeHtml(object.name),
        object.colour.r,
        object.colour.g,
        object.colour.b);
  }
  return html + "</div>";
}

}  // namespace

namespace {

Json Place(const Eigen::Vector2d& p) { return {Rounded(p.x()), Rounded(p.y())}; }

// Where room names stand, and from which side a wall is looked at.
Json LayoutData(const Layout& layout) {
  constexpr double kAboveFloor_m = 1.0;  // names stand over what the room is filled with
  Json data = {{"rooms", Json::array()}, {"walls", Json::array()}};
  for (const LayoutRoom& room : layout.rooms) {
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& corner : room.polygon_m)
      middle += corner / static_cast<double>(room.polygon_m.size());
    data["rooms"].push_back(
        {{"name", fmt::format("Room {} · {:.1f} m²", data["rooms"].size(), AreaOf(room.polygon_m))},
         {"middle_m", Vector({middle.x(), middle.y(), room.floor_m + kAboveFloor_m})}});
  }
  for (const LayoutWall& wall : layout.walls)
    data["walls"].push_back({{"from_m", Place(wall.from_m)}, {"to_m", Place(wall.to_m)}});
  return data;
}

}  // namespace

std::string_view ViewerStyle() {
  return R"css(
#viewer{border:1px solid #ddd;border-radius:6px;overflow:hidden;margin:14px 0}
.viewer-bar,.viewer-list{display:flex;flex-wrap:wrap;gap:4px 14px;padding:7px 12px;background:#fafafa;font-size:14px}
.viewer-bar{border-bottom:1px solid #ddd}.viewer-list{border-top:1px solid #ddd;max-height:130px;overflow:auto}
.viewer-bar button,.viewer-list button{font:inherit;border:1px solid #ccc;border-radius:4px;background:#fff;cursor:pointer;padding:1px 8px}
.viewer-list button[aria-pressed=true]{background:#1d3557;color:#fff}
.viewer-main{display:flex;height:520px}
.viewer-canvas{position:relative;flex:1;min-width:0;overflow:hidden}
.viewer-canvas:focus-visible{outline:3px solid #4a90d9;outline-offset:-3px}
.viewer-canvas canvas{position:absolute;width:100%;height:100%;display:block;touch-action:none}
.viewer-labels{position:absolute;inset:0;pointer-events:none}
.viewer-label{position:absolute;left:0;top:0;background:#fffd;border:1px solid #888;border-radius:4px;padding:0 6px;font-size:12px;white-space:nowrap}
.viewer-label.room{font-weight:bold;border-color:#1d3557;color:#1d3557}
.viewer-label.selected{background:#1d3557;color:#fff}
.viewer-label[hidden],.viewer-labels[hidden],.viewer-panel[hidden]{display:none}
.viewer-note{position:absolute;left:0;right:0;top:40%;text-align:center;padding:0 40px;color:#444}
.viewer-panel{width:330px;overflow:auto;border-left:1px solid #ddd;padding:4px 14px;font-size:14px;box-sizing:border-box}
.viewer-panel h3{margin:8px 0}.viewer-panel h4{margin:10px 0 4px}.viewer-panel th{font-weight:normal;color:#666;white-space:nowrap}
.viewer-candidates{list-style:none;margin:0;padding:0}
.viewer-candidates li{display:flex;gap:8px;padding:4px;border-radius:4px}.viewer-candidates li.chosen{background:#e3f5e8}
.viewer-candidates li div{min-width:0;overflow-wrap:anywhere}
.viewer-candidates img{width:56px;height:56px;flex:none}
@media(max-width:720px){.viewer-main{flex-direction:column;height:auto}.viewer-canvas{flex:none;height:380px}
.viewer-panel{width:auto;border-left:0;border-top:1px solid #ddd}}
)css";
}

std::string ViewerData(const ReportContent& content) {
  Json data = {{"objects", Json::array()}, {"layout", LayoutData(content.layout_world)}};
  for (const ObjectRow& object : content.objects) data["objects"].push_back(Object(object));
  data["trajectory_m"] = Path(content.map.frames.size(), [&](std::size_t i) {
    return content.map.frames[i].world_from_camera.translation_m;
  });
  data["tracked_m"] = Path(content.tracked_world_from_camera.size(), [&](std::size_t i) {
    return content.tracked_world_from_camera[i].translation_m;
  });
  const std::string text = data.dump(-1, ' ', true, Json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  return safe;
}

std::string ViewerSection(const ReportContent& content) {
  if (!HasView(content))
    return "<h2>The map in 3D</h2><p class=note>" + WhyNoView(content) + "</p>";
  std::string html =
      "<h2>The map in 3D</h2><p class=quiet>Click an object to see what it is and why its shape "
      "was chosen, a wall or an opening to see its measures; walls between you and their room are "
      "seen through. Drag to turn, wheel or two fingers to zoom, right button to move. With the "
      "view "
      "in focus: arrow keys turn, + and - zoom, N and P go through the objects, Escape lets go, "
      "Home shows everything.</p><div id=viewer><div class=viewer-bar>";
  html += Toggle("objects", "objects", true) + Toggle("colours", "class colours", true) +
          Toggle("seethrough", "see-through", false) +
          Toggle("measured", "measured points of objects", false) +
          Toggle("layout", "walls and openings", true) + Toggle("room", "measured room", true) +
          Toggle("ground", "floor", true) + Toggle("trajectory", "camera path", true) +
          Toggle("labels", "labels", true);
  html +=
      "<button type=button data-action=home>show everything</button></div><div "
      "class=viewer-main><div class=viewer-canvas tabindex=0 role=application aria-label='3D view "
      "of the map'><div class=viewer-labels></div><div class=viewer-note>Loading the scene. The "
      "view needs JavaScript.</div></div><div class=viewer-panel aria-live=polite hidden></div>"
      "</div>";
  html += ObjectList(content);
  html += fmt::format(
      "</div><script type='application/json' id=scene-data>{}</script><script type='text/plain' "
      "id=scene-glb>{}</script>",
      ViewerData(content),
      EncodeBase64(content.scene_glb));
  return html;
}

std::string ViewerScript(const ReportContent& content) {
  if (!HasView(content)) return {};
  return fmt::format("<script>{}</script>", ViewerBundle());
}

}  // namespace deepslam::report
