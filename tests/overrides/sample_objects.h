// Three objects to correct, and corrections as a person writes them.
#pragma once

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/artifact/overrides_yaml.h"
#include "deepslam/scene/object_class.h"
#include "deepslam/scene/object_track.h"

namespace deepslam::overrides {

inline Overrides Parsed(const std::string& text) {
  const Result<Overrides> overrides = artifact::DecodeOverrides(text, "overrides.yaml");
  EXPECT_TRUE(overrides.ok()) << overrides.error().message;
  return *overrides;
}

inline ClassTable Classes() {
  ClassTable table;
  for (const char* name : {"chair", "table"}) {
    table.classes.emplace_back();
    table.classes.back().name = name;
  }
  return table;
}

// Chair 0 in frames 0 10 20, chair 3 in 30 40, table 5 in 0 40.
inline Association ThreeObjects() {
  Association association;
  int detection = 0;
  const auto add = [&](int id, const char* class_name, const std::vector<int>& frames) {
    ObjectTrack track{ObjectId{id}, class_name, {}, "new"};
    for (const int frame : frames) {
      track.members.push_back({DetectionId{detection++}, FrameIdx{frame}, 0, 0, "vote"});
    }
    association.tracks.push_back(track);
  };
  add(0, "chair", {0, 10, 20});
  add(3, "chair", {30, 40});
  add(5, "table", {0, 40});
  return association;
}

}  // namespace deepslam::overrides
