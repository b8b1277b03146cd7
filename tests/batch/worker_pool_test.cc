// Worker processes: what they say, and how they die.
#include <gmock/gmock.h>

#include <sys/types.h>

#include <cerrno>
#include <csignal>

#include "deepslam/batch/run_program.h"
#include "deepslam/batch/worker_pool.h"

namespace deepslam::batch {
namespace {

using testing::ElementsAre;

// Answers each line with its double; `die` makes it kill itself, `leave` end with code 7.
const std::vector<std::string> kShell = {
    "-c",
    "while read -r line; do case $line in die) kill -SEGV $$;; leave) exit 7;; "
    "*) echo $line$line;; esac; done"};

std::vector<WorkerEvent> WaitFor(WorkerPool& pool, std::size_t count) {
  std::vector<WorkerEvent> all;
  for (int i = 0; i < 200 && all.size() < count; ++i) {
    for (WorkerEvent& event : pool.Wait(std::chrono::milliseconds(100)))
      all.push_back(std::move(event));
  }
  return all;
}

TEST(WorkerPool, WorkersAnswer) {
  WorkerPool pool("/bin/sh", kShell, 2);
  EXPECT_FALSE(pool.any_running());
  ASSERT_TRUE(pool.Send(0, "a").ok());
  ASSERT_TRUE(pool.Send(1, "b").ok());
  std::vector<std::string> lines(2);
  for (const WorkerEvent& event : WaitFor(pool, 2))
    lines[static_cast<std::size_t>(event.worker)] = event.line;
  EXPECT_THAT(lines, ElementsAre("aa", "bb"));
  pool.CloseInputs();
  for (const WorkerEvent& event : WaitFor(pool, 2)) {
    EXPECT_TRUE(event.ended);
    EXPECT_EQ(event.exit_code, 0);
  }
  EXPECT_FALSE(pool.any_running());
}

TEST(WorkerPool, OneThatCrashesIsToldAndReplaced) {
  WorkerPool pool("/bin/sh", kShell, 2);
  ASSERT_TRUE(pool.Send(0, "die").ok());
  const auto died = WaitFor(pool, 1);
  ASSERT_EQ(died.size(), 1U);
  EXPECT_TRUE(died[0].ended);
  EXPECT_EQ(died[0].signal, SIGSEGV);
  ASSERT_TRUE(pool.Send(0, "again").ok());
  const auto answered = WaitFor(pool, 1);
  ASSERT_EQ(answered.size(), 1U);
  EXPECT_EQ(answered[0].line, "againagain");
}

TEST(WorkerPool, ExitCodeIsTold) {
  WorkerPool pool("/bin/sh", kShell, 1);
  ASSERT_TRUE(pool.Send(0, "leave").ok());
  const auto left = WaitFor(pool, 1);
  ASSERT_EQ(left.size(), 1U);
  EXPECT_EQ(left[0].exit_code, 7);
  EXPECT_EQ(left[0].signal, 0);
}

TEST(WorkerPool, ProgramThatIsMissingEndsAtOnce) {
  WorkerPool pool("/nonexistent/program", {}, 1);
  ASSERT_TRUE(pool.Send(0, "x").ok());
  const auto ended = WaitFor(pool, 1);
  ASSERT_EQ(ended.size(), 1U);
  EXPECT_TRUE(ended[0].ended);
  EXPECT_EQ(ended[0].exit_code, 127);
}

TEST(WorkerPool, NothingOutlivesIt) {
  pid_t process = 0;
  {
    WorkerPool pool("/bin/sh", kShell, 1);
    ASSERT_TRUE(pool.Send(0, "x").ok());
    process = pool.process(0);
    ASSERT_EQ(::kill(process, 0), 0);
  }
  EXPECT_EQ(::kill(process, 0), -1);
  EXPECT_EQ(errno, ESRCH);
}

TEST(RunProgram, GivesOutputsAndCode) {
  const auto output = RunProgram({"sh", "-c", "echo out; echo err >&2; exit 3"});
  ASSERT_TRUE(output.ok()) << output.error().message;
  EXPECT_EQ(output->out, "out\n");
  EXPECT_EQ(output->err, "err\n");
  EXPECT_EQ(output->exit_code, 3);
}

TEST(RunProgram, MissingProgramIsAnError) {
  EXPECT_FALSE(RunProgram({"no-such-program-anywhere"}).ok());
  EXPECT_FALSE(HasProgram("no-such-program-anywhere"));
  EXPECT_TRUE(HasProgram("sh"));
}

}  // namespace
}  // namespace deepslam::batch
