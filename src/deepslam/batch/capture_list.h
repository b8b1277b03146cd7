// Which captures a batch holds, and how their workspaces are called.
//
// A list file has one capture per line, `PATH` or `PATH NAME`, separated by blanks:
//   # comment; empty lines are skipped
//   ../recordings/kitchen
//   "/data/second floor/room 3"  room_3        quotes around what has blanks in it
//   scans/*/depth_capture                      a pattern stands for every folder that it matches
// Relative paths start at the list's folder.
//
// A workspace is called by the name in the list, else by the capture's own name (without the
// ending, where it is a file); under a pattern by the parts of the path from the first wildcard on,
// joined by `_` (`rooms/*/seq-*`: kitchen_seq-01). A name depends on nothing but its own entry, so
// that it stays when a list grows. Letters, digits, `.`, `_`, `-` and what is beyond ASCII stay in
// a name; the rest becomes `_`.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"

namespace deepslam::batch {

struct ListedCapture {
  std::filesystem::path path;  // absolute; need not exist, unless a pattern gave it
  std::string name;            // of the workspace; unique, never with `.` or `-` in front
  std::string place;           // "rooms.txt:3" or "argument 2", for messages
  bool by_pattern = false;     // not named by itself
};

// All captures of what a user named: list files, captures (folders, .sens files) and patterns, in
// this order; those of a pattern by name. Errors are kInvalidInput: nothing there, a line that
// cannot be read, a pattern that matches nothing, two captures with one name, a path that is not
// UTF-8.
[[nodiscard]] Result<std::vector<ListedCapture>> FindCaptures(
    std::span<const std::string> arguments);

// The captures of a list's text; `name` is what messages call it. Names may still collide.
[[nodiscard]] Result<std::vector<ListedCapture>> ReadCaptureList(
    std::string_view text, std::string_view name, const std::filesystem::path& folder);

// kInvalidInput that names what collides, and what to do.
[[nodiscard]] Status CheckNames(std::span<const ListedCapture> captures);

}  // namespace deepslam::batch
