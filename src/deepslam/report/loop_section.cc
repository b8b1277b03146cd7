#include "deepslam/report/loop_section.h"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

#include "deepslam/report/html.h"

namespace deepslam::report {
namespace {

constexpr int kRunGap = 60;           // frames: keyframes nearer than this are told of in one row
constexpr std::size_t kMaxRows = 40;  // the accepted ones first; the rest stands in loops.json

struct Row {
  const char* kind = "";
  std::string what;
  bool accepted = false;
  std::string reason;
};

struct Range {
  int first = 0;
  int last = 0;

  [[nodiscard]] bool Near(FrameIdx frame) const {
    return frame.value >= first - kRunGap && frame.value <= last + kRunGap;
  }
  void Extend(FrameIdx frame) {
    first = std::min(first, frame.value);
    last = std::max(last, frame.value);
  }
  [[nodiscard]] std::string Text() const {
    return first == last ? fmt::format("frame {}", first)
                         : fmt::format("frames {} to {}", first, last);
  }
};

// An observation that was looked for by itself says when it was.
std::string Name(ObjectId id, const std::vector<SplitTracklet>& tracklets) {
  const auto tracklet = std::ranges::find(tracklets, id, &SplitTracklet::tracklet);
  if (tracklet == tracklets.end()) return fmt::format("{:02d}", id.value);
  return fmt::format("{:02d} (as seen in {})",
                     tracklet->object.value,
                     Range{tracklet->first.value, tracklet->last.value}.Text());
}

Row ConstellationRow(const Constellation& constellation,
                     const std::vector<SplitTracklet>& tracklets) {
  std::string pairs;
  for (const ObjectMerge& pair : constellation.pairs) {
    if (!pairs.empty()) pairs += ", ";
    pairs += fmt::format("{} is {}", Name(pair.merged, tracklets), Name(pair.kept, tracklets));
  }
  const bool single = constellation.pairs.size() == 1;
  return {single ? "duplicate" : "constellation",
          (single ? "object " : "objects ") + pairs,
          constellation.accepted,
          constellation.reason};
}

// Neighbours with one verdict make one row.
std::vector<Row> AppearanceRows(const std::vector<AppearanceLoop>& loops) {
  struct KeyframeRun {
    Range older, newer;
    const AppearanceLoop* like = nullptr;
    int count = 0;
  };
  std::vector<KeyframeRun> runs;
  for (const AppearanceLoop& loop : loops) {
    const auto known = std::find_if(runs.begin(), runs.end(), [&](const KeyframeRun& s) {
      return s.like->accepted == loop.accepted && s.like->reason == loop.reason &&
             s.older.Near(loop.old_keyframe) && s.newer.Near(loop.new_keyframe);
    });
    if (known == runs.end()) {
      runs.push_back({{loop.old_keyframe.value, loop.old_keyframe.value},
                      {loop.new_keyframe.value, loop.new_keyframe.value},
                      &loop,
                      1});
      continue;
    }
    known->older.Extend(loop.old_keyframe);
    known->newer.Extend(loop.new_keyframe);
    ++known->count;
  }
  std::vector<Row> rows;
  for (const KeyframeRun& run : runs) {
    rows.push_back({"appearance",
                    fmt::format("{} and {}, {} {}",
                                run.older.Text(),
                                run.newer.Text(),
                                run.count,
                                run.count == 1 ? "pair" : "pairs"),
                    run.like->accepted,
                    run.like->reason});
  }
  return rows;
}

}  // namespace

std::string LoopSection(const Loops& loops) {
  std::vector<Row> rows;
  for (const Constellation& constellation : loops.constellations)
    rows.push_back(ConstellationRow(constellation, loops.tracklets));
  for (Row& row : AppearanceRows(loops.appearance)) rows.push_back(std::move(row));
  if (rows.empty()) return "<h2>Places seen again</h2><p>None was found.</p>";
  std::stable_sort(rows.begin(), rows.end(), [](const Row& a, const Row& b) {
    return a.accepted && !b.accepted;
  });
  std::string html = "<h2>Places seen again</h2><table><tr><th>kind<th>what<th>verdict<th>why</tr>";
  for (std::size_t k = 0; k < std::min(rows.size(), kMaxRows); ++k) {
    html += fmt::format("<tr><td>{}<td>{}<td>{}<td>{}</tr>",
                        rows[k].kind,
                        EscapeHtml(rows[k].what),
                        rows[k].accepted ? "accepted" : "refused",
                        EscapeHtml(rows[k].reason));
  }
  html += "</table>";
  if (rows.size() > kMaxRows) {
    html +=
        fmt::format("<p class=quiet>and {} more in loops/loops.json</p>", rows.size() - kMaxRows);
  }
  return html;
}

}  // namespace deepslam::report
