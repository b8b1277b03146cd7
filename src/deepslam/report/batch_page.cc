#include "deepslam/report/batch_page.h"

#include <algorithm>
#include <map>
#include <numeric>

#include <fmt/format.h>

#include "deepslam/core/base64.h"
#include "deepslam/report/html.h"

namespace deepslam::report {
namespace {

constexpr std::string_view kStyle = R"css(
:root{color-scheme:light}
body{font:15px/1.4 system-ui,sans-serif;margin:0 auto;max-width:1240px;padding:24px;color:#1a1a1a}
h1{margin:0 0 4px}h2{margin:26px 0 8px;border-bottom:1px solid #ddd;padding-bottom:4px}
.quiet{color:#666;font-size:13px}
.tiles{display:flex;flex-wrap:wrap;gap:10px;margin:16px 0}
.tile{padding:8px 14px;border-radius:6px;background:#f2f4f6;min-width:84px}.tile b{display:block;font-size:22px}
.good{background:#e3f5e8}.doubtful{background:#fff3d6}.bad,.failed{background:#fde2e2}
.controls{display:flex;flex-wrap:wrap;gap:8px;align-items:center;margin:8px 0}
.controls input,.controls select{font:inherit;padding:4px 8px;border:1px solid #bbb;border-radius:4px}
table{border-collapse:collapse;width:100%}
th{position:sticky;top:0;background:#fff;text-align:left;padding:6px 10px 6px 0;border-bottom:2px solid #ccc;white-space:nowrap}
th button{font:inherit;font-weight:600;border:0;background:none;padding:0;cursor:pointer}
th[aria-sort=ascending] button::after{content:' \25B2'}th[aria-sort=descending] button::after{content:' \25BC'}
td{padding:5px 10px 5px 0;border-bottom:1px solid #eee;vertical-align:top}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
td.name{overflow-wrap:anywhere;min-width:130px}td.pic{width:108px}
td.pic img{width:100px;height:67px;object-fit:cover;border-radius:4px;display:block;background:#eee}
.badge{display:inline-block;padding:1px 8px;border-radius:9px;white-space:nowrap}
.why{font-size:13px;color:#555;margin:2px 0 0;padding:0;list-style:none}
.fault{color:#a02020;overflow-wrap:anywhere;white-space:pre-wrap}
@media(max-width:820px){.wide{display:none}}
@media print{.controls{display:none}th{position:static}}
)css";

// Rows carry the sort keys as data; cells without a figure sort last both ways.
constexpr std::string_view kScript = R"js(
const body = document.getElementById('rows');
const rows = [...body.rows];
const search = document.getElementById('search'), kind = document.getElementById('kind');
const shown = document.getElementById('shown');
function filter() {
  const text = search.value.trim().toLowerCase();
  let n = 0;
  for (const row of rows) {
    const fits = (!kind.value || row.dataset.kind === kind.value) &&
      (!text || row.textContent.toLowerCase().includes(text));
    row.hidden = !fits;
    n += fits;
  }
  shown.textContent = n + ' of ' + rows.length + ' shown';
}
search.addEventListener('input', filter);
kind.addEventListener('change', filter);
document.querySelectorAll('th button').forEach(button => button.addEventListener('click', () => {
  const th = button.closest('th'), key = button.dataset.key;
  const down = th.getAttribute('aria-sort') === 'ascending';
  document.querySelectorAll('th').forEach(other => other.removeAttribute('aria-sort'));
  th.setAttribute('aria-sort', down ? 'descending' : 'ascending');
  const value = row => row.dataset[key];
  const numeric = button.dataset.numeric !== undefined;
  rows.sort((a, b) => {
    const x = value(a), y = value(b);
    if (x === '' || y === '') return (x === '') - (y === '');
    const order = numeric ? x - y : x.localeCompare(y, undefined, {numeric: true});
    return down ? -order : order;
  });
  body.append(...rows);
}));
document.querySelector('.controls').hidden = false;
filter();
)js";

// Links may hold any UTF-8: all but what a path is made of is escaped.
std::string Href(std::string_view link) {
  std::string escaped;
  for (const char c : link) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = (byte >= 'a' && byte <= 'z') || (byte >= 'A' && byte <= 'Z') ||
                       (byte >= '0' && byte <= '9') || byte == '/' || byte == '.' || byte == '_' ||
                       byte == '-';
    escaped += plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return escaped;
}

std::string Duration(double seconds) {
  if (seconds < 60) return fmt::format("{:.1f} s", seconds);
  if (seconds < 3600) return fmt::format("{:.1f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

// What a row counts as: its verdict, else its state.
std::string KindOf(const BatchRow& row) {
  return row.state == "done" && !row.verdict.empty() ? row.verdict : row.state;
}

int NumObjects(const BatchRow& row) {
  return std::accumulate(
      row.objects.begin(), row.objects.end(), 0, [](int sum, const auto& o) { return sum + o.second; });
}

double Median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

std::string Tile(std::string_view value, std::string_view label, std::string_view css = "") {
  return fmt::format(
      "<div class='tile {}'><b>{}</b>{}</div>", css, EscapeHtml(value), EscapeHtml(label));
}

std::string Tiles(const BatchPage& page) {
  std::map<std::string, int> kinds;
  std::vector<double> errors_m;
  double wall_s = 0;
  int num_objects = 0, num_frames = 0;
  for (const BatchRow& row : page.rows) {
    ++kinds[KindOf(row)];
    if (row.ate_m) errors_m.push_back(*row.ate_m);
    wall_s += row.wall_s;
    num_objects += NumObjects(row);
    num_frames += row.num_frames;
  }
  std::string html = "<div class=tiles>" + Tile(std::to_string(page.rows.size()), "captures");
  for (const char* kind :
       {"good", "doubtful", "bad", "done", "failed", "running", "waiting", "interrupted"}) {
    if (kinds[kind] > 0) html += Tile(std::to_string(kinds[kind]), kind, kind);
  }
  html += Tile(std::to_string(num_objects), "objects") +
          Tile(std::to_string(num_frames), "frames") + Tile(Duration(wall_s), "of work");
  if (!errors_m.empty()) {
    html += Tile(fmt::format("{:.3f} m", Median(errors_m)),
                 fmt::format("median ATE of {}", errors_m.size()));
  }
  return html + "</div>";
}

std::string Failures(const BatchPage& page) {
  std::string list;
  int count = 0;
  for (const BatchRow& row : page.rows) {
    if (row.state != "failed") continue;
    ++count;
    list += fmt::format("<tr><td class=name>{}<td class=fault>{}<td>{}</tr>",
                        EscapeHtml(row.name),
                        EscapeHtml(row.failure),
                        row.log_link.empty()
                            ? std::string()
                            : fmt::format("<a href='{}'>log</a>", Href(row.log_link)));
  }
  if (count == 0) return {};
  return fmt::format(
      "<h2>Failures</h2><p class=quiet>{} could not be finished. The same command again tries them "
      "again and leaves the others as they are.</p><table>{}</table>",
      count == 1 ? "1 capture" : fmt::format("{} captures", count),
      list);
}

// The whole of a failure stands in the list of failures.
std::string_view FirstLine(std::string_view text) {
  constexpr std::size_t kMaxShownBytes = 160;  // about two lines of the table's cell
  text = text.substr(0, text.find('\n'));
  if (text.size() <= kMaxShownBytes) return text;
  std::size_t end = kMaxShownBytes;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
  return text.substr(0, end);
}

std::string ResultCell(const BatchRow& row) {
  const std::string kind = KindOf(row);
  std::string html = fmt::format("<span class='badge {0}'>{0}</span>", EscapeHtml(kind));
  if (!row.failure.empty())
    return html + "<div class='why fault'>" + EscapeHtml(FirstLine(row.failure)) + "</div>";
  if (row.verdict_reasons.empty()) return html;
  html += "<ul class=why>";
  for (const std::string& reason : row.verdict_reasons) html += "<li>" + EscapeHtml(reason);
  return html + "</ul>";
}

std::string ObjectsCell(const BatchRow& row) {
  std::string text;
  for (const auto& [class_name, count] : row.objects)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, class_name);
  return EscapeHtml(text);
}

std::string RowHtml(const BatchRow& row) {
  const bool assessed = !row.verdict.empty();
  const std::string ate = row.ate_m ? fmt::format("{:.6f}", *row.ate_m) : std::string();
  std::string html = fmt::format(
      "<tr data-kind='{}' data-name='{}' data-objects='{}' data-frames='{}' data-ate='{}' "
      "data-wall='{}' data-size='{}'>",
      EscapeHtml(KindOf(row)),
      EscapeHtml(row.name),
      assessed ? std::to_string(NumObjects(row)) : std::string(),
      row.num_frames > 0 ? std::to_string(row.num_frames) : std::string(),
      ate,
      row.wall_s > 0 ? fmt::format("{:.2f}", row.wall_s) : std::string(),
      row.megabytes > 0 ? fmt::format("{:.3f}", row.megabytes) : std::string());
  const std::string picture =
      row.thumbnail.bytes.empty()
          ? std::string()
          : fmt::format("<img loading=lazy decoding=async alt='' src='data:{};base64,{}'>",
                        EscapeHtml(row.thumbnail.mime),
                        EncodeBase64(row.thumbnail.bytes));
  const std::string name = EscapeHtml(row.name);
  const auto linked = [&](const std::string& inner) {
    return row.report_link.empty() || inner.empty()
               ? inner
               : fmt::format("<a href='{}'>{}</a>", Href(row.report_link), inner);
  };
  html += fmt::format("<td class=pic>{}<td class=name>{}<td>{}<td>{}",
                      linked(picture),
                      linked(name),
                      ResultCell(row),
                      ObjectsCell(row));
  html += fmt::format(
      "<td class=n>{}<td class=n>{}<td class=n>{}<td class='n wide'>{}</tr>",
      row.num_frames > 0 ? std::to_string(row.num_frames) : std::string(),
      row.ate_m ? fmt::format("{:.3f} m<div class=why>{} of {} frames</div>",
                              *row.ate_m,
                              row.num_scored,
                              row.num_estimated)
                : std::string(),
      row.wall_s > 0 ? Duration(row.wall_s) : std::string(),
      row.megabytes > 0 ? fmt::format("{:.1f} MB", row.megabytes) : std::string());
  return html;
}

std::string Controls(const BatchPage& page) {
  std::map<std::string, int> kinds;
  for (const BatchRow& row : page.rows) ++kinds[KindOf(row)];
  std::string html =
      "<div class=controls hidden><input id=search type=search placeholder='search names, classes, "
      "reasons' size=32 aria-label=search><select id=kind aria-label=result><option value=''>all "
      "results</option>";
  for (const auto& [kind, count] : kinds) {
    html += fmt::format("<option value='{0}'>{0} ({1})</option>", EscapeHtml(kind), count);
  }
  return html + "</select><span id=shown class=quiet></span></div>";
}

std::string Heading(std::string_view label, std::string_view key, bool numeric) {
  return fmt::format("<th{}><button data-key={}{}>{}</button>",
                     numeric ? " class=n" : "",
                     key,
                     numeric ? " data-numeric" : "",
                     label);
}

}  // namespace

std::string RenderBatchPage(const BatchPage& page) {
  std::string html = fmt::format(
      "<!DOCTYPE html><html lang=en><head><meta charset=utf-8><meta name=viewport "
      "content='width=device-width,initial-scale=1'><link rel=icon href='data:,'><title>{0} - "
      "deepslam</title><style>{1}</style></head><body><h1>{0}</h1><div class=quiet>deepslam {2}; "
      "{3}</div>",
      EscapeHtml(page.title),
      kStyle,
      EscapeHtml(page.tool_version),
      EscapeHtml(page.when));
  html += Tiles(page) + Failures(page) + "<h2>Captures</h2>" + Controls(page);
  html += "<table><thead><tr><th>" + Heading("name", "name", false) +
          Heading("result", "kind", false) + Heading("objects", "objects", false) +
          Heading("frames", "frames", true) + Heading("ATE", "ate", true) +
          Heading("time", "wall", true);
  html += "<th class='n wide'><button data-key=size data-numeric>size</button></tr></thead><tbody "
          "id=rows>";
  for (const BatchRow& row : page.rows) html += RowHtml(row) + "\n";
  html += fmt::format(
      "</tbody></table><p class=quiet>ATE: root mean square distance of the camera path from the "
      "poses that came with the capture, after rigid alignment. Pictures are renderings of the "
      "maps.</p><script>{}</script></body></html>\n",
      kScript);
  return html;
}

}  // namespace deepslam::report
