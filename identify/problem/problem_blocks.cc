#include "identify/problem/problem_blocks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "sim/base/error.h"
#include "sim/base/text_file.h"

namespace clothid {
namespace {

std::vector<std::string> FittedNames(const std::vector<RecordedMotion>& motions, const FitOptions& options) {
  if (!options.parameters.empty()) return options.parameters;
  const bool has_obstacles = std::any_of(motions.begin(), motions.end(),
                                         [](const RecordedMotion& motion) { return !motion.scene.obstacles.empty(); });
  std::vector<std::string> names;
  if (has_obstacles) names.emplace_back("mu");
  if (motions.front().scene.self_contact) names.push_back(ParameterName({ParameterKind::kSelfFriction}, {}));
  if (motions.front().scene.membrane == MembraneLaw::kArap) {
    names.emplace_back("k_stretch");
  } else {
    names.insert(names.end(), {"k_warp", "k_weft"});
  }
  return names;
}

// "mu" is in every scene, but says something only where there are obstacles.
bool TellsOf(const RecordedMotion& motion, const std::string& name) {
  return HasParameter(motion.scene, name) && (name != "mu" || !motion.scene.obstacles.empty());
}

// The recording that gives start and bounds of `name`: the first that has it. Where none has it, the first one, whose
// error message lists the names it knows.
const RecordedMotion& RecordingOf(const std::string& name, const std::vector<RecordedMotion>& motions) {
  const auto found =
      std::find_if(motions.begin(), motions.end(), [&](const RecordedMotion& motion) { return TellsOf(motion, name); });
  return found == motions.end() ? motions.front() : *found;
}

// "mu" is the friction of every obstacle, so it cannot be fitted beside the friction of one of them, but beside that of
// the cloth with itself; nor a constant of the whole cloth beside that of a piece.
void CheckOverlap(const std::vector<std::string>& names) {
  const std::string self_friction = ParameterName({ParameterKind::kSelfFriction}, {});
  const auto check = [&](const std::string& whole, const std::string& what) {
    if (std::find(names.begin(), names.end(), whole) == names.end()) return;
    for (const std::string& name : names) {
      if (name.rfind(whole + ".", 0) != 0 || name == self_friction) continue;
      throw Error(ErrorKind::kUsage,
                  "--fit: '" + whole + "' sets " + what + ", so '" + name + "' cannot be fitted beside it");
    }
  };
  check("mu", "the friction of every obstacle");
  for (const ParameterKind kind : MaterialKinds()) check(ParameterName({kind}, {}), "that of every piece");
}

// Expands groups of names, and refuses names that would not come out.
std::vector<std::string> Expand(const std::vector<std::string>& names, const std::string& flag) {
  const std::vector<std::string> expanded = ExpandAlignmentNames(names);
  for (const std::string& name : expanded) {
    if (BaseName(name) != name) {
      throw Error(ErrorKind::kUsage, flag + ": '" + Printable(name) +
                                         "': expected a name without '@'; --each makes one parameter per recording");
    }
    if (std::count(expanded.begin(), expanded.end(), name) > 1) {
      throw Error(ErrorKind::kUsage, flag + ": '" + Printable(name) + "' is given twice");
    }
  }
  return expanded;
}

// One block per recording that has the parameter. Where none has it, that of the first, or its error message.
std::vector<ParameterBlock> BlocksOfEach(const std::string& name, const std::vector<RecordedMotion>& motions,
                                         const ParameterOverrides& overrides) {
  std::vector<ParameterBlock> blocks;
  for (std::size_t r = 0; r < motions.size(); ++r) {
    if (!TellsOf(motions[r], name) && &RecordingOf(name, motions) != &motions[r]) continue;
    const std::string suffix = motions.size() > 1 ? "@" + std::to_string(r + 1) : "";
    blocks.push_back(MakeParameterBlock(name + suffix, motions[r], overrides));
    blocks.back().recording = static_cast<int>(r);
  }
  return blocks;
}

// The levels of fields are parameters like others. One level for all recordings: they have the field in common.
void AddLevels(const std::vector<FieldRequest>& fields, const std::vector<std::string>& each,
               std::vector<std::string>* names) {
  for (const FieldRequest& field : fields) {
    if (std::find(each.begin(), each.end(), field.name) != each.end()) {
      throw Error(ErrorKind::kUsage, "--each: '" + field.name + "' is a field, which all recordings have in common");
    }
    if (std::find(names->begin(), names->end(), field.name) == names->end()) names->push_back(field.name);
  }
}

std::vector<ParameterBlock> BlocksOf(const std::vector<RecordedMotion>& motions, const FitOptions& options) {
  std::vector<std::string> names = Expand(FittedNames(motions, options), "--fit");
  const std::vector<std::string> each = Expand(options.each, "--each");
  const auto contains = [](const std::vector<std::string>& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  for (const std::string& name : each) {
    if (!contains(names, name)) names.push_back(name);
  }
  AddLevels(options.fields, each, &names);
  CheckOverlap(names);
  std::vector<ParameterBlock> blocks;
  for (const std::string& name : names) {
    if (!contains(each, name)) {
      blocks.push_back(MakeParameterBlock(name, RecordingOf(name, motions), options.overrides));
      continue;
    }
    const std::vector<ParameterBlock> own = BlocksOfEach(name, motions, options.overrides);
    blocks.insert(blocks.end(), own.begin(), own.end());
  }
  return blocks;
}

template <typename Value>
void CheckOverrides(const std::map<std::string, Value>& values, const std::vector<ParameterBlock>& blocks,
                    const std::string& flag) {
  for (const auto& [name, value] : values) {
    const bool is_known = std::any_of(blocks.begin(), blocks.end(), [&given = name](const ParameterBlock& block) {
      const std::vector<std::string> names = OverrideNames(block.name);
      return std::find(names.begin(), names.end(), given) != names.end();
    });
    if (!is_known) {
      throw Error(ErrorKind::kUsage, flag + ": '" + name + "' is not among the fitted parameters");
    }
  }
}

// The times of the profile that a block has a knot of: the first scene that has it tells.
const Eigen::VectorXd& KnotTimes(const ParameterBlock& block, int knot, const std::vector<RecordedMotion>& motions) {
  if (block.recording != kEveryRecording) return motions[block.recording].scene.wind.profile.times;
  for (const RecordedMotion& motion : motions) {
    if (knot < motion.scene.wind.profile.num_knots()) return motion.scene.wind.profile.times;
  }
  return motions.front().scene.wind.profile.times;
}

// Links every knot to the one before it, where both are among `blocks`, of the same component and recording: their
// difference has the standard deviation smoothness sqrt(time between them), m/s. Throws `Error` (kUsage) where no two
// are.
void LinkKnots(const std::vector<RecordedMotion>& motions, double smoothness, std::vector<ParameterBlock>* blocks) {
  bool has_links = false;
  for (ParameterBlock& block : *blocks) {
    const int knot = block.id.part;
    if (!IsWindKnot(block.id) || knot == 0) continue;
    const auto before = std::find_if(blocks->begin(), blocks->end(), [&](const ParameterBlock& other) {
      return other.id == ParameterId{block.id.kind, block.id.axis, knot - 1} && other.recording == block.recording;
    });
    if (before == blocks->end()) continue;
    const Eigen::VectorXd& times = KnotTimes(block, knot, motions);
    block.linked_to = static_cast<int>(before - blocks->begin());
    block.link_spread = smoothness * std::sqrt(times[knot] - times[knot - 1]);
    has_links = true;
  }
  if (!has_links) {
    throw Error(ErrorKind::kUsage,
                "--wind_smoothness: expected with --wind_profile, or with successive knots in --fit or --each, as "
                "wind.x.1,wind.x.2");
  }
}

}  // namespace

void SetFlatFields(const FitOptions& options, std::vector<RecordedMotion>* motions) {
  for (const FieldRequest& field : options.fields) {
    const auto given = options.overrides.start.find(field.name);
    const Parameters nominal = motions->front().scene.nominal_parameters();
    const double level = given == options.overrides.start.end() ? GetParameter(nominal, {field.kind}) : given->second;
    if (!(level > 0.0)) {
      throw Error(ErrorKind::kUsage, "--field: '" + field.name + "' is 0 in the scene; expected one that gives it");
    }
    SetField({field.kind, Eigen::MatrixXd::Constant(field.rows, field.columns, level)}, motions);
  }
}

bool HasParameter(const Scene& scene, const std::string& name) {
  const std::string base = BaseName(name);
  if (const auto id = FindParameter(base, scene.obstacle_names(), scene.mesh.piece_names)) {
    return IsPlacement(id->kind) || scene.has(*id);
  }
  // Of another scene's obstacle or piece; a name of nothing is refused by who makes a block of it.
  const std::optional<ParameterId> whole = FindParameter(base.substr(0, base.find('.')));
  return !whole || (whole->kind != ParameterKind::kFriction && RowOf(whole->kind).constant == nullptr);
}

bool Concerns(const ParameterBlock& block, const RecordedMotion& motion, int recording) {
  return (block.recording == kEveryRecording || block.recording == recording) && HasParameter(motion.scene, block.name);
}

std::vector<ParameterBlock> MakeBlocks(const std::vector<RecordedMotion>& motions, const FitOptions& options) {
  std::vector<ParameterBlock> blocks = BlocksOf(motions, options);
  CheckOverrides(options.overrides.start, blocks, "--start");
  CheckOverrides(options.overrides.lower_bounds, blocks, "--lower");
  CheckOverrides(options.overrides.upper_bounds, blocks, "--upper");
  CheckOverrides(options.overrides.priors, blocks, "--prior");
  if (std::all_of(blocks.begin(), blocks.end(), [](const ParameterBlock& block) { return block.frozen; })) {
    throw Error(ErrorKind::kUsage, "--fit: every parameter is frozen by the scene");
  }
  if (options.wind_smoothness > 0.0) LinkKnots(motions, options.wind_smoothness, &blocks);
  return blocks;
}

}  // namespace clothid
