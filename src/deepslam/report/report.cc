#include "deepslam/report/report.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "deepslam/report/html.h"
#include "deepslam/report/plots.h"

namespace deepslam::report {
namespace {

constexpr std::string_view kStyle = R"css(
:root{color-scheme:light}
body{font:15px/1.45 system-ui,sans-serif;margin:0 auto;max-width:1100px;padding:24px;color:#1a1a1a}
h1{margin:0 0 4px}h2{margin:32px 0 8px;border-bottom:1px solid #ddd;padding-bottom:4px}
.verdict{padding:10px 14px;border-radius:6px;margin:14px 0;font-size:16px}
.good{background:#e3f5e8}.doubtful{background:#fff3d6}.bad{background:#fde2e2}
table{border-collapse:collapse;width:100%;margin:8px 0}
th,td{text-align:left;padding:4px 10px 4px 0;border-bottom:1px solid #eee;vertical-align:top}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}
tr.chosen td{font-weight:600}
.pictures{display:flex;flex-wrap:wrap;gap:10px}
figure{margin:0;flex:1 1 300px;max-width:520px}figure img{width:100%;border-radius:4px;display:block}
figcaption{font-size:13px;color:#555}
.crops figure{flex:0 0 170px}
svg{width:100%;background:#fafafa;border:1px solid #eee;border-radius:4px}
svg .grid{stroke:#ddd;fill:none}svg text{font:12px system-ui,sans-serif}
.swatch{display:inline-block;width:12px;height:12px;border-radius:3px;margin-right:6px}
.note{color:#9a5b00}.quiet{color:#666;font-size:13px}
details{margin:6px 0}summary{cursor:pointer}
)css";

// Fills the table of times from `../timing.js` (deepslamTiming = [{stage, wall_s, cpu_s, peak_mb,
// reused}]).
constexpr std::string_view kTimingScript = R"js(
if (typeof deepslamTiming !== 'undefined') {
  const rows = deepslamTiming.map(t => {
    const tr = document.createElement('tr');
    const cells = [t.stage, t.wall_s.toFixed(1), t.cpu_s.toFixed(1), Math.round(t.peak_mb), t.reused ? 'reused' : 'ran'];
    cells.forEach((c, i) => { const td = document.createElement('td'); td.textContent = c;
      if (i > 0 && i < 4) td.className = 'n'; tr.appendChild(td); });
    return tr; });
  document.getElementById('times').append(...rows);
  document.getElementById('timing').hidden = false;
}
)js";

std::string Image(const Picture& picture) {
  return fmt::format(
      "<figure><img alt='{0}' src='data:{1};base64,{2}'><figcaption>{0}</figcaption></figure>",
      EscapeHtml(picture.caption),
      picture.mime,
      Base64(picture.bytes));
}

std::string Gallery(const std::vector<Picture>& pictures, std::string_view extra_class) {
  if (pictures.empty()) return {};
  std::string html = fmt::format("<div class='pictures {}'>", extra_class);
  for (const Picture& picture : pictures) html += Image(picture);
  return html + "</div>";
}

std::string Verdict(const ReportContent& content) {
  std::string html =
      fmt::format("<div class='verdict {0}'><b>Result: {0}.</b> ", EscapeHtml(content.verdict));
  for (const std::string& reason : content.verdict_reasons) html += EscapeHtml(reason) + ". ";
  return html + "</div>";
}

struct StatusCounts {
  int tracked = 0;
  int degenerate = 0;
  int lost = 0;
  int unreadable = 0;
};

StatusCounts CountStatus(const std::vector<TrackedFrame>& frames) {
  StatusCounts counts;
  for (const TrackedFrame& frame : frames) {
    switch (frame.status) {
      case TrackingStatus::kTracked:
        ++counts.tracked;
        break;
      case TrackingStatus::kDegenerate:
        ++counts.degenerate;
        break;
      case TrackingStatus::kLost:
        ++counts.lost;
        break;
      case TrackingStatus::kUnreadable:
        ++counts.unreadable;
        break;
    }
  }
  return counts;
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
      "<p class=quiet>Room from above, 1 m grid. Camera path green where tracked, orange where a "
      "direction was "
      "weak, red where lost; dots are keyframes, the dashed line is the path before the graph. The "
      "thick side of "
      "an object is its front.</p>";
  html += TopView(content);
  html +=
      "<p class=quiet>Height of the camera above the ground; the strip shows each frame's "
      "status.</p>";
  return html + HeightOverTime(content.map.frames);
}

std::string CandidateTable(const ObjectRow& object) {
  if (object.candidates.empty()) return {};
  std::string html = fmt::format(
      "<details><summary>{} candidates competed; why this one "
      "won</summary><table><tr><th>shape<th>source<th "
      "class=n>score<th class=n>depth on model<th class=n>model seen<th class=n>through solid<th "
      "class=n>views<th></tr>",
      object.candidates.size());
  for (const CandidateRow& row : object.candidates) {
    html += fmt::format(
        "<tr{}><td>{}<td>{}<td class=n>{:.3f}<td class=n>{:.0f} %<td class=n>{:.0f} %<td "
        "class=n>{:.1f} %<td "
        "class=n>{}<td>{}</tr>",
        row.chosen ? " class=chosen" : "",
        EscapeHtml(row.model),
        EscapeHtml(row.source),
        row.score,
        100 * row.surface_share,
        100 * row.coverage_share,
        100 * row.free_violation,
        row.num_views,
        EscapeHtml(row.note));
  }
  return html + "</table></details>";
}

std::string ObjectTable(const ReportContent& content) {
  std::string html =
      "<table><tr><th>object<th>size (front x side x height)<th class=n>above ground<th "
      "class=n>confidence<th "
      "class=n>views<th>shape from<th>doubts</tr>";
  for (const ObjectRow& o : content.objects) {
    html += fmt::format(
        "<tr><td><span class=swatch style='background:rgb({},{},{})'></span>{}<td>{:.2f} x {:.2f} "
        "x {:.2f} m<td "
        "class=n>{:+.1f} cm<td class=n>{:.2f}<td class=n>{}<td>{}<td class=note>{}</tr>",
        o.colour.r,
        o.colour.g,
        o.colour.b,
        EscapeHtml(o.name),
        o.size_m.x(),
        o.size_m.y(),
        o.size_m.z(),
        100 * o.bottom_above_ground_m,
        o.confidence,
        o.num_views,
        EscapeHtml(o.source),
        EscapeHtml(o.note));
  }
  return html + "</table>";
}

std::string ObjectSection(const ReportContent& content) {
  std::string html = fmt::format("<h2>Objects ({})</h2>", content.objects.size());
  if (content.objects.empty()) return html + "<p>No object entered the map.</p>";
  html += ObjectTable(content);
  for (const ObjectRow& object : content.objects) {
    html += fmt::format("<h3>{}</h3>", EscapeHtml(object.name));
    html += Gallery(object.pictures, "crops");
    html += CandidateTable(object);
    if (!object.credit.empty())
      html += fmt::format("<p class=quiet>Model: {}</p>", EscapeHtml(object.credit));
  }
  return html;
}

std::string GraphSection(const OptimizationSummary& summary) {
  std::string html = fmt::format(
      "<h2>Graph</h2><p>{} after {} iterations. {}</p><table><tr><th>term<th class=n>edges<th "
      "class=n>energy before<th "
      "class=n>after</tr>",
      summary.converged ? "Converged" : "Did not converge",
      summary.num_iterations,
      EscapeHtml(summary.message));
  for (const EnergyTerm& term : summary.terms) {
    html += fmt::format("<tr><td>{}<td class=n>{}<td class=n>{:.4g}<td class=n>{:.4g}</tr>",
                        EscapeHtml(term.name),
                        term.num_edges,
                        term.before,
                        term.after);
  }
  return html + "</table>";
}

std::string RunSection(const ReportContent& content) {
  std::string html = "<h2>Stages</h2><table>";
  for (const auto& [stage, summary] : content.stage_summaries) {
    html += fmt::format("<tr><td>{}<td>{}</tr>", EscapeHtml(stage), EscapeHtml(summary));
  }
  html +=
      "</table><div id=timing hidden><h3>Times of the last run</h3><table "
      "id=times><tr><th>stage<th class=n>wall "
      "s<th class=n>CPU s<th class=n>peak MB<th></tr></table></div>";
  html += "<h2>Files</h2><table>";
  for (const auto& [file, bytes] : content.file_bytes) {
    html += fmt::format("<tr><td>{}<td class=n>{:.1f} KB</tr>",
                        EscapeHtml(file),
                        static_cast<double>(bytes) / 1000.0);
  }
  return html + "</table>";
}

std::string WarningSection(const std::vector<std::string>& warnings) {
  if (warnings.empty()) return {};
  std::string html = "<h2>Warnings</h2><ul class=note>";
  for (const std::string& warning : warnings) html += "<li>" + EscapeHtml(warning) + "</li>";
  return html + "</ul>";
}

}  // namespace

std::string RenderReport(const ReportContent& content) {
  std::string html = fmt::format(
      "<!DOCTYPE html><html lang=en><head><meta charset=utf-8><meta name=viewport "
      "content='width=device-width,initial-scale=1'><title>{0} - "
      "deepslam</title><style>{1}</style></head><body>"
      "<h1>{0}</h1><div class=quiet>deepslam {2}, capture {3}</div>",
      EscapeHtml(content.title),
      kStyle,
      EscapeHtml(content.tool_version),
      EscapeHtml(content.capture_hash.substr(0, 16)));
  html += Verdict(content);
  html += Gallery(content.scene_pictures, "");
  html += WarningSection(content.warnings);
  html += ObjectSection(content);
  html += CameraSection(content);
  if (!content.frame_pictures.empty()) html += "<h2>Detections and segments</h2>";
  html += Gallery(content.frame_pictures, "");
  html += GraphSection(content.map.summary);
  html += RunSection(content);
  html += fmt::format("<script src='../timing.js'></script><script>{}</script></body></html>\n",
                      kTimingScript);
  return html;
}

}  // namespace deepslam::report
