# Sourced by the tests of this folder, which run under tools/slurm/single_node: what they ask of Slurm.
# shellcheck shell=bash

readonly patience=600  # s, for whatever Slurm is to do

fail() {
  echo "slurm test: $1" >&2
  exit 1
}

# need_program PROGRAM FLAG: FLAG is what names another.
need_program() { [[ -x "$1" ]] || fail "there is no program '$1'; build it, or name it with $2"; }

# make_folder: sets `folder`, which goes when the test ends.
make_folder() {
  folder=$(mktemp --directory "${TMPDIR:-/tmp}/clothid_slurm_test_XXXXXX")
  trap 'rm -rf "$folder"' EXIT
  trap 'exit 130' INT
  trap 'exit 143' TERM HUP
}

# await WHAT COMMAND...: until the command succeeds.
await() {
  local what=$1 end=$((SECONDS + patience))
  shift
  until "$@"; do
    ((SECONDS < end)) || fail "waited $patience s for $what"
    sleep 0.05
  done
}

# job_field JOB FIELD: what Slurm says about a job, such as JobState or Restarts.
job_field() { scontrol show job --oneliner "$1" | grep --only-matching --perl-regexp "\\b$2=\\K\\S+"; }
has_state() { [[ "$(job_field "$1" JobState)" == "$2" ]]; }
has_ended() { [[ ! "$(job_field "$1" JobState)" =~ ^(PENDING|CONFIGURING|RUNNING|COMPLETING|REQUEUED)$ ]]; }

# expect_state JOB STATE: how a job has to end.
expect_state() {
  local log
  await "the end of job $1" has_ended "$1"
  if ! has_state "$1" "$2"; then
    log=$(tail --lines=1 "$(job_field "$1" StdOut)" 2>/dev/null || true)
    fail "job $1 ended as $(job_field "$1" JobState), not $2; its log ends with: $log"
  fi
}

# expect_restarts JOB TIMES
expect_restarts() {
  [[ "$(job_field "$1" Restarts)" == "$2" ]] || fail "job $1 restarted $(job_field "$1" Restarts) times, not $2"
}

# restart JOB TIMES: Slurm keeps a requeued task for two minutes; we do not.
restart() {
  await "job $1 to return to the queue" has_state "$1" PENDING
  expect_restarts "$1" "$2"
  scontrol update "JobId=$1" StartTime=now
}

# job_of WORD TEXT: the id of the job that a submission, TEXT, calls WORD.
job_of() { grep --only-matching --perl-regexp "^$1 \\K\\d+" <<<"$2"; }
