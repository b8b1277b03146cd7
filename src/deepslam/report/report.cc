#include "deepslam/report/report.h"

#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "deepslam/report/explain.h"
#include "deepslam/report/html.h"
#include "deepslam/report/loop_section.h"
#include "deepslam/report/object_section.h"
#include "deepslam/report/plots.h"
#include "deepslam/report/viewer_section.h"

namespace deepslam::report {
namespace {

constexpr std::string_view kStyle = R"css(
:root{color-scheme:light}
body{font:15px/1.45 system-ui,sans-serif;margin:0 auto;max-width:1100px;padding:24px;color:#1a1a1a}
h1{margin:0 0 4px}h2{margin:32px 0 8px;border-bottom:1px solid #ddd;padding-bottom:4px}
.verdict{padding:10px 14px;border-radius:6px;margin:14px 0 6px;font-size:16px}.verdict ul{margin:6px 0 0}
.corrections{background:#e8eefc;padding:8px 14px;border-radius:6px;margin:6px 0}.corrections ul{margin:4px 0 0}
.good{background:#e3f5e8}.doubtful{background:#fff3d6}.bad{background:#fde2e2}
table{border-collapse:collapse;width:100%;margin:8px 0}
th,td{text-align:left;padding:4px 10px 4px 0;border-bottom:1px solid #eee;vertical-align:top}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}td.name{white-space:nowrap}
.facts td:first-child{width:46px;font-weight:600}.facts th{width:110px}.fine{color:#1e7d3c}.look{color:#b25f00}
tr.chosen td{font-weight:600}.wide{overflow-x:auto}
figure{margin:0}figure img{width:100%;border-radius:4px;display:block}
figcaption{font-size:13px;color:#555}
.pictures,.pairs{display:grid;gap:12px;align-items:start}
.pairs,.large{grid-template-columns:repeat(2,minmax(0,1fr))}.frames{grid-template-columns:repeat(3,minmax(0,1fr))}
.crops{display:flex;flex-wrap:wrap}.crops img{width:auto;height:165px;max-width:100%;object-fit:contain;object-position:left}
.thumbnails{display:flex;flex-wrap:wrap;gap:6px}.thumbnails figure{width:76px;padding:3px;border:2px solid transparent;border-radius:6px;text-align:center}
.thumbnails .chosen{border-color:#2a9d4e}
.object{margin:0 0 22px}
svg{width:100%;background:#fafafa;border:1px solid #eee;border-radius:4px}svg.map{max-height:620px}
svg .grid{stroke:#ddd;fill:none}svg text{font:12px system-ui,sans-serif}
.swatch{display:inline-block;width:12px;height:12px;border-radius:3px;margin-right:6px}
.note{color:#9a5b00}.quiet{color:#666;font-size:13px}
details{margin:6px 0}summary{cursor:pointer}
.bar{height:9px;background:#8fb3d9;border-radius:2px}
@media(max-width:720px){.pairs,.large,.frames{grid-template-columns:1fr}}
)css";

// Fills the table of times from `../timing.html` (see report.h). A frame whose file is missing says
// nothing, where a missing script would be an error on the console.
constexpr std::string_view kTimingScript = R"js(
window.addEventListener('message', (event) => {
  if (event.source !== document.getElementById('timing-source').contentWindow) return;
  const timing = event.data.deepslamTiming;
  if (!Array.isArray(timing)) return;
  const slowest = Math.max(1e-9, ...timing.map(t => t.wall_s));
  const rows = timing.map(t => {
    const tr = document.createElement('tr');
    const cells = [t.stage, t.wall_s.toFixed(1), t.cpu_s.toFixed(1), Math.round(t.peak_mb), t.reused ? 'reused' : 'ran'];
    cells.forEach((c, i) => { const td = document.createElement('td'); td.textContent = c;
      if (i > 0 && i < 4) td.className = 'n'; tr.appendChild(td); });
    const bar = document.createElement('div'); bar.className = 'bar';
    bar.style.width = (100 * t.wall_s / slowest).toFixed(1) + '%';
    const td = document.createElement('td'); td.style.width = '35%'; td.append(bar); tr.append(td);
    return tr; });
  const total = timing.filter(t => !t.reused).reduce((sum, t) => sum + t.wall_s, 0);
  document.getElementById('total').textContent = total.toFixed(1);
  document.getElementById('times').append(...rows);
  document.getElementById('timing').hidden = false;
  document.getElementById('no-timing').hidden = true;
});
)js";

std::string Corrections(const std::vector<std::string>& corrections) {
  if (corrections.empty()) return {};
  std::string html =
      "<div class=corrections><b>Corrected by hand</b> (overrides.yaml); without it this run would "
      "show something else:<ul>";
  for (const std::string& correction : corrections)
    html += "<li>" + EscapeHtml(correction) + "</li>";
  return html + "</ul></div>";
}

std::string Overview(const ReportContent& content) {
  std::string html = fmt::format("<div class='verdict {0}'><b>Result: {0}.</b> {1}",
                                 EscapeHtml(content.verdict),
                                 EscapeHtml(MeaningOf(content.verdict)));
  if (!content.verdict_reasons.empty()) {
    html += "<ul>";
    for (const std::string& reason : content.verdict_reasons)
      html += "<li>" + EscapeHtml(reason) + "</li>";
    html += "</ul>";
  }
  html += "</div>" + Corrections(content.corrections) + "<table class=facts>";
  for (const Fact& fact : Facts(content)) {
    html += fmt::format(
        "<tr><td class={}>{}<th>{}<td>{}{}</tr>",
        fact.fine ? "fine" : "look",
        fact.fine ? "fine" : "look",
        EscapeHtml(fact.subject),
        EscapeHtml(fact.finding),
        fact.remedy.empty() ? "" : " <span class=quiet>" + EscapeHtml(fact.remedy) + "</span>");
  }
  return html + "</table>";
}

std::string Photographs(const std::vector<PicturePair>& pairs) {
  if (pairs.empty()) return {};
  std::string html =
      "<h2>Photograph and map</h2><p class=quiet>Left what the camera saw, right the map from the "
      "same place: objects should stand where they do in the photograph.</p><div class=pairs>";
  for (const PicturePair& pair : pairs) html += Figure(pair.photograph) + Figure(pair.map);
  return html + "</div>";
}

std::string DriftPlots(const ReportContent& content) {
  std::string html;
  const std::string moved = GraphCorrection(content.map.frames, content.tracked_world_from_camera);
  if (!moved.empty()) {
    html +=
        "<p class=quiet>How far the adjustment moved each frame, with the first frame held in "
        "place. Steps and slopes are drift that was taken out.</p>" +
        moved;
  }
  const std::string drift =
      HeightDrift(content.heights, static_cast<int>(content.map.frames.size()));
  if (!drift.empty()) {
    html +=
        "<p class=quiet>Drift that needs no truth to see: camera height of the path minus the "
        "height read off the floor in the same frame; dashed before the adjustment, solid after. "
        "Near zero is good.</p>" +
        drift;
  }
  return html;
}

std::string CameraSection(const ReportContent& content) {
  const StatusCounts n = CountStatus(content.map.frames);
  std::string html = fmt::format(
      "<h2>Camera</h2><p>{} frames: <b>{}</b> tracked, {} with a weak direction, {} lost, {} "
      "unreadable; {} "
      "keyframes. {}</p>",
      content.map.frames.size(),
      n.tracked,
      n.degenerate,
      n.lost,
      n.unreadable,
      content.map.keyframes.size(),
      content.map.has_ground ? "The ground was found; the world is level, z = 0 on the floor."
                             : "No ground was found; heights are relative to the first camera.");
  html +=
      "<p class=quiet>The floor plan, also in export/plan.svg. Walls as thick as was seen, dashed "
      "where a room was closed by a guess; doors with the arc of a leaf (which way it opens is not "
      "known), windows as double lines, in dashes what is doubtful; the thick side of an object is "
      "its front. The camera's path lies over it: green where tracked, orange where a direction "
      "was weak, red where lost; dots are keyframes, the dashed line is the path before the "
      "graph.</p>";
  html += PlanWithPath(content);
  html +=
      "<p class=quiet>Height of the camera above the ground; the strip shows each frame's "
      "status.</p>";
  return html + HeightOverTime(content.map.frames) + DriftPlots(content);
}

// What a term of the graph holds together.
std::string_view TermInWords(std::string_view term) {
  constexpr std::pair<std::string_view, std::string_view> kWords[] = {
      {"r_io", "objects stand where each frame saw them"},
      {"r_ij", "the path is as it was tracked"},
      {"r_pi", "the floor lies where each frame saw it"},
      {"r_po", "objects are upright on the floor"},
      {"loop", "places seen again are the same places"},
      {"r_pw", "walls are flat wherever they were seen from"}};
  for (const auto& [name, words] : kWords) {
    if (name == term) return words;
  }
  return {};
}

std::string GraphSection(const OptimizationSummary& summary) {
  std::string html = fmt::format(
      "<h2>Graph</h2><p>{} after {} iterations. {}</p><p class=quiet>What the adjustment weighs "
      "against each other, and how far from agreement each is (0 = full agreement); the sum went "
      "down "
      "as far as it goes.</p><table><tr><th>term<th><th class=n>edges<th "
      "class=n>energy before<th "
      "class=n>after</tr>",
      summary.converged ? "Converged" : "Did not converge",
      summary.num_iterations,
      EscapeHtml(summary.message));
  for (const EnergyTerm& term : summary.terms) {
    html += fmt::format("<tr><td>{}<td>{}<td class=n>{}<td class=n>{:.4g}<td class=n>{:.4g}</tr>",
                        EscapeHtml(term.name),
                        TermInWords(term.name),
                        term.num_edges,
                        term.before,
                        term.after);
  }
  return html + "</table>";
}

// The same room as a map, as meshes and as points.
std::string SizeTable(const ReportContent& content) {
  const ResultSizes& sizes = content.sizes;
  if (sizes.map_json == 0 || sizes.fused_cloud == 0) return {};
  const double cloud = static_cast<double>(sizes.fused_cloud);
  std::string html =
      "<h3>The same room in other forms</h3><table><tr><th>form<th class=n>size<th class=n>an "
      "object<th class=n>smaller than the cloud</tr>";
  for (const auto& [form, bytes] :
       {std::pair("map.json: class, shape, place of every object, and the floor", sizes.map_json),
        std::pair("meshes of the objects, compressed (GLB)", sizes.objects_glb),
        std::pair("scene.glb: the objects, and the measured room, floor and path", sizes.scene_glb),
        std::pair("the fused surface as points at 1 cm, 15 bytes each (reckoned from its area)",
                  sizes.fused_cloud)}) {
    if (bytes == 0) continue;
    const bool of_objects = bytes <= sizes.objects_glb && !content.objects.empty();
    html += fmt::format(
        "<tr><td>{}<td class=n>{}<td class=n>{}<td class=n>{}</tr>",
        form,
        BytesInWords(bytes),
        of_objects ? BytesInWords(bytes / content.objects.size()) : "",
        bytes == sizes.fused_cloud ? "" : fmt::format("{:.0f} x", cloud / double(bytes)));
  }
  return html + "</table>";
}

std::string RunSection(const ReportContent& content) {
  std::string html = "<h2>Stages</h2><table>";
  for (const auto& [stage, summary] : content.stage_summaries) {
    html += fmt::format("<tr><td>{}<td>{}</tr>", EscapeHtml(stage), EscapeHtml(summary));
  }
  html +=
      "</table><p id=no-timing class=quiet>The times of the last run lie beside the workspace's "
      "reports, in timing.html; this page was opened without it.</p><div id=timing "
      "hidden><h3>Times of the last run</h3><p "
      "class=quiet>Stages that ran took <span id=total></span> s. Peak memory is that of the "
      "process while the stage ran.</p><table id=times><tr><th>stage<th class=n>wall s<th "
      "class=n>CPU s<th class=n>peak MB<th><th></tr></table></div>";
  html += "<h2>Files</h2><table>";
  for (const auto& [file, bytes] : content.file_bytes) {
    html += fmt::format("<tr><td>{}<td class=n>{}</tr>", EscapeHtml(file), BytesInWords(bytes));
  }
  return html + "</table>" + SizeTable(content);
}

std::string WarningSection(const std::vector<std::string>& warnings) {
  if (warnings.empty()) return {};
  std::string html = "<h2>Warnings</h2><ul class=note>";
  for (const std::string& warning : warnings) html += "<li>" + EscapeHtml(warning) + "</li>";
  return html + "</ul>";
}

// Pictures first, then what there is none of.
std::string NotMappedSection(const std::vector<Picture>& not_mapped) {
  if (not_mapped.empty()) return {};
  std::vector<Picture> pictures;
  std::string rest;
  for (const Picture& thing : not_mapped) {
    if (thing.bytes.empty())
      rest += "<li>" + EscapeHtml(thing.caption) + "</li>";
    else
      pictures.push_back(thing);
  }
  return "<h2>Seen and not mapped</h2><p class=quiet>What has some surface in the capture and is "
         "no "
         "object of the map, each in the frame that shows most of it, with the reason.</p>" +
         Gallery(pictures, "frames") + (rest.empty() ? "" : "<ul class=note>" + rest + "</ul>");
}

}  // namespace

std::string RenderReport(const ReportContent& content) {
  std::string html = fmt::format(
      "<!DOCTYPE html><html lang=en><head><meta charset=utf-8><meta name=viewport "
      "content='width=device-width,initial-scale=1'><link rel=icon href='data:,'><title>{0} - "
      "deepslam</title><style>{1}{2}</style></head><body>"
      "<h1>{0}</h1><div class=quiet>deepslam {3}, capture {4}</div>",
      EscapeHtml(content.title),
      kStyle,
      ViewerStyle(),
      EscapeHtml(content.tool_version),
      EscapeHtml(content.capture_hash.substr(0, 16)));
  html += Overview(content);
  html += ViewerSection(content);
  html += Photographs(content.photographs);
  if (!content.scene_pictures.empty()) html += "<h2>Overview pictures</h2>";
  html += Gallery(content.scene_pictures, "large");
  html += WarningSection(content.warnings);
  html += ObjectSection(content);
  html += NotMappedSection(content.not_mapped);
  html += CameraSection(content);
  if (!content.frame_pictures.empty()) {
    html +=
        "<h2>Detections and segments</h2><p class=quiet>What was found in some of the frames; one "
        "colour is one object of the map, grey belongs to none.</p>";
  }
  html += Gallery(content.frame_pictures, "frames");
  html += LoopSection(content.loops);
  html += GraphSection(content.map.summary);
  html += RunSection(content);
  html += "<p class=quiet>3D view: three.js (MIT), Draco (Apache-2.0).</p>";
  html += ViewerScript(content);
  html += fmt::format(
      "<script>{}</script><iframe id=timing-source src='../timing.html' hidden "
      "title=times></iframe></body></html>\n",
      kTimingScript);
  return html;
}

}  // namespace deepslam::report
