// The scripts of tools/slurm without Slurm: an `sbatch` that runs jobs at once and a program that writes down its
// arguments stand in. tools/slurm/test runs them under a real Slurm.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/tools/tool_test.h"

namespace clothid::slurm_test {
namespace {

namespace fs = std::filesystem;

constexpr char kSlurm[] = CLOTHID_SOURCE_DIR "/tools/slurm";

// Gives an array the id 12 and any other job 13.
constexpr char kSbatch[] = R"(#!/usr/bin/env bash
set -euo pipefail
printf '%s\n' "$@" >>sbatch_arguments
last=
while [[ "$1" == -* ]]; do
  [[ "$1" != --array=0-* ]] || last=${1#--array=0-} last=${last%%%*}
  shift
done
if [[ -z "$last" ]]; then
  bash "$@"
  echo 13
  exit
fi
export SLURM_ARRAY_TASK_MIN=0 SLURM_ARRAY_TASK_MAX=$last SLURM_ARRAY_TASK_COUNT=$((last + 1)) SLURM_CPUS_PER_TASK=2
for ((i = 0; i <= last; ++i)); do SLURM_ARRAY_TASK_ID=$i bash "$@"; done
echo '12;name_of_the_cluster'
)";

// Its last argument is the folder of its output.
constexpr char kProgram[] = R"(#!/usr/bin/env bash
mkdir -p "${!#}"
printf '%s\n' "$@" >"${!#}/arguments"
printf '%s' "$OMP_NUM_THREADS" >"${!#}/omp_num_threads"
)";

std::string Lines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

class SlurmTest : public ToolTest {
 protected:
  SlurmTest() {
    fs::create_directory(folder() / "bin");
    WriteProgram("bin/sbatch", kSbatch);
    WriteProgram("program", kProgram);
  }

  void WriteProgram(const std::string& name, const std::string& text) const {
    WriteBytes(folder() / name, text);
    fs::permissions(folder() / name, fs::perms::owner_all);
  }

  std::string Submit(const std::string& arguments) const {
    return "PATH=\"$PWD/bin:$PATH\" '" + std::string(kSlurm) + "/submit' --landscape ./program " + arguments;
  }

  // Task 1 of an array of 3, running `program`.
  std::string Task(const std::string& variables = "") const {
    return "PATH=\"$PWD/bin:$PATH\" SLURM_ARRAY_JOB_ID=12 SLURM_ARRAY_TASK_ID=1 SLURM_ARRAY_TASK_MIN=0 "
           "SLURM_ARRAY_TASK_MAX=2 SLURM_ARRAY_TASK_COUNT=3 " +
           variables + " bash '" + kSlurm + "/landscape.sbatch' ./program out --target motion.bin";
  }
};

TEST_F(SlurmTest, ArgumentsReachEveryTaskUnchanged) {
  const ToolResult result =
      Run("OMP_NUM_THREADS=8 " +
          Submit(R"(3%2 'of mine; 50 %a' --time=1:00:00 -- --target 'a b;$HOME*.bin' --sweep "a=1,2;b='3'" '')"));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const fs::path output = folder() / "of mine; 50 %a";
  for (const std::string task : {"0", "1", "2"}) {
    const fs::path shard = output / ("shard_" + task);
    EXPECT_EQ(ReadBytes(shard / "arguments"),
              Lines({"--target", "a b;$HOME*.bin", "--sweep", "a=1,2;b='3'", "", "--shard", task + "/3", "--resume",
                     "--threads", "2", "--output", shard.string()}));
    EXPECT_EQ(ReadBytes(shard / "omp_num_threads"), "1");
  }
  EXPECT_EQ(ReadBytes(output / "merged" / "arguments"), Lines({"merge", output / "shard_0", output / "shard_1",
                                                               output / "shard_2", "--output", output / "merged"}));
}

TEST_F(SlurmTest, MergeWaitsForTheArrayAndBothIdsArePrinted) {
  const ToolResult result = Run(Submit("3%2 out --time=1:00:00 -- --target motion.bin"));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out.rfind("array 12: 3 shards", 0), 0) << result.out;
  EXPECT_NE(result.out.find("\nmerge 13: "), std::string::npos) << result.out;
  const std::string arguments = ReadBytes(folder() / "sbatch_arguments");
  const size_t merge = arguments.find("--parsable", 1);
  ASSERT_NE(merge, std::string::npos) << arguments;
  EXPECT_LT(arguments.find("--array=0-2%2\n"), merge) << arguments;
  EXPECT_GT(arguments.find("--dependency=afterok:12\n"), merge) << arguments;
  EXPECT_LT(arguments.find("--time=1:00:00\n"), merge) << arguments;
  EXPECT_NE(arguments.find("--time=1:00:00\n", merge), std::string::npos) << arguments;
}

TEST_F(SlurmTest, BadSubmissionsAreRefused) {
  ExpectRefused(Submit("0 out -- --target motion.bin"), 1, "N is '0'");
  ExpectRefused(Submit("3.5 out -- --target motion.bin"), 1, "N is '3.5'");
  ExpectRefused(Submit("3"), 1, "usage");
  ExpectRefused(Submit("--time=10 3 out -- --target motion.bin"), 1, "usage");
  ExpectRefused(Submit("3 out --target motion.bin"), 1, "after --");
  ExpectRefused(Submit("3 out --array=0-9 -- --target motion.bin"), 1, "--array=0-9");
  for (const std::string flag : {"--shard", "--resume", "-threads=4", "--output=here"})
    ExpectRefused(Submit("3 out -- --target motion.bin " + flag), 1, flag);
  ExpectRefused(std::string(kSlurm) + "/submit --landscape ./nothing 3 out -- --target motion.bin", 1, "./nothing");
}

TEST_F(SlurmTest, AFolderGoesOnWithItsOwnScanOnly) {
  ExpectSuccess(Submit("3 out -- --target motion.bin"));
  ExpectSuccess(Submit("3%1 out --time=10 -- --target motion.bin"));
  ExpectRefused(Submit("2 out -- --target motion.bin"), 1, "another scan, with N and arguments 3 --target motion.bin");
  ExpectRefused(Submit("3 out -- --target other.bin"), 1, "another scan");
}

TEST_F(SlurmTest, PartOfAnArrayIsRefused) {
  ExpectRefused(Task("SLURM_ARRAY_TASK_COUNT=2"), 1, "without gaps");
  ExpectRefused(Task("SLURM_ARRAY_TASK_MIN=1"), 1, "without gaps");
  ExpectRefused(Task("SLURM_ARRAY_TASK_ID="), 1, "usage");
}

TEST_F(SlurmTest, ExitCodeIsThatOfTheProgram) {
  WriteProgram("program", "#!/bin/sh\nexit 2\n");
  EXPECT_EQ(Run(Task()).exit_code, 2);
}

// The signal comes while the program runs, and the program goes on.
TEST_F(SlurmTest, TaskThatRunsOutOfTimeIsRequeued) {
  WriteProgram("bin/scontrol", "#!/bin/sh\necho \"$@\" >>scontrol_arguments\n");
  const std::string signals = "kill -USR1 $PPID\nsleep 0.2\nexit 3\n";
  WriteProgram("program", "#!/bin/sh\nmkdir -p out/shard_1\necho a cell >>out/shard_1/cells\n" + signals);
  EXPECT_EQ(Run(Task()).exit_code, 3);
  EXPECT_EQ(ReadBytes(folder() / "scontrol_arguments"), "requeue 12_1\n");

  // Nothing finished in all of its time: it never would be.
  WriteProgram("program", "#!/bin/sh\n" + signals);
  const ToolResult result = Run(Task());
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_NE(result.err.find("raise --time"), std::string::npos) << result.err;
  EXPECT_EQ(ReadBytes(folder() / "scontrol_arguments"), "requeue 12_1\n");
}

}  // namespace
}  // namespace clothid::slurm_test
