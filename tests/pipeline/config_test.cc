#include <array>

#include <gmock/gmock.h>

#include "deepslam/pipeline/config.h"

namespace deepslam::pipeline {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

struct Options {
  double reach_m = 2.5;
  int steps = 4;
  bool on = true;
  std::string mode = "fast";
  std::string file;
};

constexpr std::array<std::string_view, 2> kModes = {"fast", "slow"};

std::vector<OptionSection> Sections(Options& a, Options& b) {
  const auto describe = [](Options& o) {
    return [&o](OptionsVisitor& visitor) {
      visitor.Field("reach_m", o.reach_m, {0, 10}, "m", "how far it reaches");
      visitor.Field("steps", o.steps, {1, 9}, "1", "how many steps");
      visitor.Field("on", o.on, "whether it is on");
      visitor.Choice("mode", o.mode, kModes, "how fast");
      visitor.Field("file", o.file, "a file");
      visitor.Retired("files", "`file` takes one");
    };
  };
  return {{"first", "The first part", describe(a)}, {"first.inner", "Its inner part", describe(b)}};
}

TEST(Config, SetsNestedOptions) {
  Options a;
  Options b;
  const Status status =
      ApplyYaml(Sections(a, b),
                "first:\n  reach_m: 1e-1\n  on: false\n  inner:\n    mode: slow\n    file: 'a b'\n",
                "f");
  ASSERT_TRUE(status.ok()) << status.error().message;
  EXPECT_EQ(a.reach_m, 0.1);
  EXPECT_FALSE(a.on);
  EXPECT_EQ(b.mode, "slow");
  EXPECT_EQ(b.file, "a b");
  EXPECT_EQ(b.reach_m, 2.5);
}

TEST(Config, TellsAllFaultsAtOnceWithLineAndNearestName) {
  Options a;
  Options b;
  const Status status = ApplyYaml(Sections(a, b),
                                  "first:\n"
                                  "  raech_m: 1\n"
                                  "  steps: 2.5\n"
                                  "  reach_m: 11\n"
                                  "  mode: medium\n"
                                  "  on: maybe\n"
                                  "  file: [1, 2]\n"
                                  "second:\n"
                                  "  x: 1\n",
                                  "my.yaml");
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kInvalidConfig);
  EXPECT_THAT(
      status.error().message,
      AllOf(HasSubstr("my.yaml:2: unknown option first.raech_m, did you mean first.reach_m?"),
            HasSubstr("my.yaml:3: first.steps is \"2.5\", must be an integer"),
            HasSubstr("my.yaml:4: first.reach_m is \"11\", must lie in [0, 10] m"),
            HasSubstr("my.yaml:5: first.mode is \"medium\", must be one of fast, slow"),
            HasSubstr("my.yaml:6: first.on"),
            HasSubstr("my.yaml:7: first.file"),
            HasSubstr("second.x")));
}

TEST(Config, TellsWhatTookThePlaceOfAnOptionThatThereWas) {
  Options a;
  Options b;
  const std::vector<OptionSection> sections = Sections(a, b);
  const std::string expected = "first.inner.files is no option any more: `file` takes one";
  const Status file = ApplyYaml(sections, "first:\n  inner:\n    files: x\n", "f.yaml");
  ASSERT_FALSE(file.ok());
  EXPECT_EQ(file.error().message, "f.yaml:3: " + expected);
  const Status setting = ApplySettings(sections, std::vector<std::string>{"first.inner.files=x"});
  ASSERT_FALSE(setting.ok());
  EXPECT_THAT(setting.error().message, HasSubstr(expected));
  for (const OptionEntry& entry : ListOptions(sections)) EXPECT_NE(entry.name, "first.inner.files");
  EXPECT_EQ(DumpConfig(sections).find("files"), std::string::npos);
}

TEST(Config, RefusesNumbersThatAreNone) {
  for (const char* value : {"nan", "inf", "-inf", "1e999", "0x10", "1,5", "", "1 m"}) {
    Options a;
    Options b;
    EXPECT_FALSE(ApplySettings(Sections(a, b),
                               std::vector<std::string>{"first.reach_m=" + std::string(value)})
                     .ok())
        << value;
  }
}

TEST(Config, RefusesBrokenYaml) {
  for (const char* text : {"first: [",
                           "- 1\n- 2\n",
                           "first:\n  steps: 1\n  steps: 2\n",
                           "just a word",
                           "a: &a [x]\nb: *c\n",
                           "first: 3"}) {
    Options a;
    Options b;
    const Status status = ApplyYaml(Sections(a, b), text, "f.yaml");
    ASSERT_FALSE(status.ok()) << text;
    EXPECT_THAT(status.error().message, HasSubstr("f.yaml:")) << text;
  }
  Options a;
  Options b;
  EXPECT_TRUE(ApplyYaml(Sections(a, b), "", "empty.yaml").ok());
  EXPECT_TRUE(ApplyYaml(Sections(a, b), "# nothing\nfirst:\n", "empty.yaml").ok());
}

TEST(Config, SaysOfManyAndOfLongFaultsNoMoreThanCanBeRead) {
  std::string many = "second:\n";
  for (int n = 0; n < 5000; ++n) many += "  x" + std::to_string(n) + ": 1\n";
  std::string places;  // of two bytes each, so that half of all cuts would split one
  for (int n = 0; n < 5000; ++n) places += "\xC3\xA9";
  Options a;
  Options b;
  const Status unknown = ApplyYaml(Sections(a, b), many, "f.yaml");
  ASSERT_FALSE(unknown.ok());
  EXPECT_THAT(unknown.error().message, AllOf(HasSubstr("f.yaml:2: "), HasSubstr("and more")));
  EXPECT_LT(unknown.error().message.size(), 10'000U);
  for (const std::string& mode : {places, "x" + places}) {
    const Status wrong = ApplyYaml(Sections(a, b), "first:\n  mode: " + mode + "\n", "f.yaml");
    ASSERT_FALSE(wrong.ok());
    EXPECT_THAT(wrong.error().message,
                AllOf(HasSubstr("f.yaml:2: first.mode is"), EndsWith("\xC3\xA9...")));
    EXPECT_LT(wrong.error().message.size(), 2000U);
  }
}

TEST(Config, DumpReadsBackToTheSameValues) {
  for (const std::string text :
       {"with \"quotes\": and # more", "", "null", "NULL", "~", "-", "true"}) {
    Options a{1.0 / 3.0, 7, false, "slow", text};
    Options b;
    const std::string dump = DumpConfig(Sections(a, b));
    EXPECT_THAT(
        dump,
        AllOf(HasSubstr("# how far it reaches [0 .. 10 m]"), HasSubstr("how fast [fast | slow]")));
    Options c;
    Options d;
    const Status status = ApplyYaml(Sections(c, d), dump, "dump");
    ASSERT_TRUE(status.ok()) << status.error().message;
    EXPECT_EQ(DumpConfig(Sections(c, d)), dump);
  }
}

TEST(Config, CommandLineSettings) {
  Options a;
  Options b;
  ASSERT_TRUE(
      ApplySettings(Sections(a, b), std::vector<std::string>{"first.steps=2", "first.steps=3"})
          .ok());
  EXPECT_EQ(a.steps, 3);
  EXPECT_THAT(
      ApplySettings(Sections(a, b), std::vector<std::string>{"first.steps"}).error().message,
      HasSubstr("must be NAME=VALUE"));
}

TEST(Config, EqualValuesHaveEqualCanonicalText) {
  Options a;
  Options b;
  ASSERT_TRUE(ApplySettings(Sections(a, b), std::vector<std::string>{"first.reach_m=2.50e0"}).ok());
  Options c;
  EXPECT_EQ(OptionValues(Sections(a, b)[0]), OptionValues(Sections(c, b)[0]));
}

}  // namespace
}  // namespace deepslam::pipeline
