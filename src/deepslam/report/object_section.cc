#include "deepslam/report/object_section.h"

#include <fmt/format.h>

#include "deepslam/core/base64.h"
#include "deepslam/report/explain.h"
#include "deepslam/report/html.h"

namespace deepslam::report {
namespace {

std::string DataUri(const Picture& picture) {
  return fmt::format("data:{};base64,{}", EscapeHtml(picture.mime), EncodeBase64(picture.bytes));
}

// The candidates as pictures, the winner framed; the 3D view borrows them by their ids.
std::string Thumbnails(const ObjectRow& object, std::size_t index) {
  std::string html;
  for (std::size_t n = 0; n < object.candidates.size(); ++n) {
    const CandidateRow& row = object.candidates[n];
    if (row.thumbnail.bytes.empty()) continue;
    html += fmt::format(
        "<figure{}><img id='candidate-{}-{}' alt='{}' src='{}'><figcaption>{:.3f}{}</figcaption>"
        "</figure>",
        row.chosen ? " class=chosen" : "",
        index,
        n,
        EscapeHtml(row.model),
        DataUri(row.thumbnail),
        row.score,
        row.chosen ? " chosen" : "");
  }
  if (html.empty()) return html;
  return "<div class='pictures thumbnails'>" + html + "</div>";
}

std::string CandidateTable(const ObjectRow& object) {
  if (object.candidates.empty()) return {};
  std::string html = fmt::format(
      "<details><summary>Figures of the {} candidates</summary><table><tr><th>shape<th>source<th "
      "class=n>score<th class=n>depth on model<th class=n>model seen<th class=n>through solid<th "
      "class=n>views<th></tr>",
      object.candidates.size());
  for (const CandidateRow& row : object.candidates) {
    html += fmt::format(
        "<tr{}><td>{}<td>{}<td class=n>{:.3f}<td class=n>{:.0f} %<td class=n>{:.0f} %<td "
        "class=n>{:.1f} %<td class=n>{}<td>{}</tr>",
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
  return html +
         "</table><p class=quiet>Depth on model: share of the measured points that lie on the "
         "shape. Model seen: share of the surface that should be visible and was measured there. "
         "Through solid: share of measurements that pass through the shape before they end.</p>"
         "</details>";
}

std::string ObjectTable(const ReportContent& content) {
  std::string html =
      "<div class=wide><table><tr><th>object<th>size (front x side x height)<th class=n>above "
      "floor<th class=n>confidence<th class=n>views<th>shape from<th>notes</tr>";
  for (const ObjectRow& o : content.objects) {
    html += fmt::format(
        "<tr><td class=name><span class=swatch "
        "style='background:rgb({},{},{})'></span>{}<td>{:.2f} x {:.2f} x {:.2f} m<td "
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
  return html + "</table></div>";
}

std::string OneObject(const ObjectRow& object, std::size_t index) {
  std::string html = fmt::format("<section class=object><h3>{}</h3>", EscapeHtml(object.name));
  if (!object.pictures.empty())
    html += "<p class=quiet>Photographs with the outline of the chosen shape.</p>";
  html += Gallery(object.pictures, "crops");
  const std::string why = WhyItWon(object);
  if (!why.empty()) html += "<p>" + EscapeHtml(why) + "</p>";
  html += Thumbnails(object, index);
  html += CandidateTable(object);
  if (!object.credit.empty())
    html += fmt::format("<p class=quiet>Model: {}</p>", EscapeHtml(object.credit));
  return html + "</section>";
}

}  // namespace

std::string Figure(const Picture& picture) {
  return fmt::format("<figure><img alt='{0}' src='{1}'><figcaption>{0}</figcaption></figure>",
                     EscapeHtml(picture.caption),
                     DataUri(picture));
}

std::string Gallery(const std::vector<Picture>& pictures, std::string_view extra_class) {
  if (pictures.empty()) return {};
  std::string html = fmt::format("<div class='pictures {}'>", extra_class);
  for (const Picture& picture : pictures) html += Figure(picture);
  return html + "</div>";
}

std::string ObjectSection(const ReportContent& content) {
  std::string html = fmt::format("<h2>Objects ({})</h2>", content.objects.size());
  if (content.objects.empty()) return html + "<p>No object entered the map.</p>";
  html += ObjectTable(content);
  for (std::size_t n = 0; n < content.objects.size(); ++n) html += OneObject(content.objects[n], n);
  return html;
}

}  // namespace deepslam::report
