# Sourced by the scripts of this folder: how they fail, read their arguments, and find what is complete.
# shellcheck shell=bash
# shellcheck disable=SC2034  # variables that are set here are used there

fail() {
  echo "${0##*/}: $1" >&2
  exit 1
}

# find_program PROGRAM FLAG: sets `program` to its absolute path; FLAG is what names another.
find_program() {
  command -v "$1" >/dev/null || fail "there is no program '$1'; build it, or name it with $2"
  program=$(realpath "$(command -v "$1")")
}

# take_tasks N[%K] WHAT: sets `num_tasks` and `at_a_time`, %K or nothing.
take_tasks() {
  [[ "$1" =~ ^([1-9][0-9]*)(%[1-9][0-9]*)?$ ]] || fail "N is '$1', expected a number of $2 >= 1, or N%K"
  num_tasks=${BASH_REMATCH[1]} at_a_time=${BASH_REMATCH[2]}
}

# take_options [SBATCH_OPTION...] -- REST...: sets the arrays `options` and `rest`; the latter is empty without --.
take_options() {
  options=() rest=()
  while (($#)) && [[ "$1" != -- ]]; do
    [[ "$1" != -a* && "$1" != --array* ]] || fail "sbatch option $1: the array is made from N"
    options+=("$1")
    shift
  done
  if (($# > 1)); then rest=("${@:2}"); fi
}

# refuse_flags FLAGS WHAT ARGUMENT...: fails where an argument is one of the flags (a|b|..), which each task gets.
refuse_flags() {
  local argument
  for argument in "${@:3}"; do
    [[ ! "$argument" =~ ^--?($1)(=|$) ]] || fail "$argument: each task has its own $2"
  done
}

# read_commands FILE: sets the array `commands`, a line each, without blank lines and comments.
read_commands() {
  [[ -r "$1" ]] || fail "cannot read the commands '$1'"
  mapfile -t commands < <(grep --invert-match --extended-regexp '^[[:space:]]*(#|$)' "$1")
}

# split_command LINE: sets `output`, the folder that its command fills, `result`, the file that it ends with, both below
# that of the array, and `call`, the command as a shell reads it.
split_command() {
  [[ "$1" =~ ^([A-Za-z0-9_][A-Za-z0-9._/-]*)/([A-Za-z0-9._-]+)[[:space:]]+(.+)$ && "/$1/" != */../* ]] || return 1
  output=${BASH_REMATCH[1]} result=${BASH_REMATCH[1]}/${BASH_REMATCH[2]} call=${BASH_REMATCH[3]}
}

# is_complete DIR: whether the command that was split has its result, and did end (array_task writes exit_code).
is_complete() { [[ -s "$1/$output/exit_code" && -e "$1/$result" ]]; }
