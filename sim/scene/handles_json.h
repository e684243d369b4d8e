// The handles of a scene as JSON: see "handles" in datasets/scene.md.
#ifndef CLOTHID_SIM_SCENE_HANDLES_JSON_H_
#define CLOTHID_SIM_SCENE_HANDLES_JSON_H_

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "sim/base/json_document.h"
#include "sim/path/handle_path.h"
#include "sim/path/rigid_path.h"
#include "sim/scene/scene.h"

namespace clothid {

// Reads in two parts, as handles stand on their paths before what takes them along is known. All errors are `Error`s
// that name key and line (kBadData) or a file that cannot be read (kIo).
class HandlesReader {
 public:
  // `node`, which must outlive the reader, is the value of the key. Relative names of files start at `folder`. Takes
  // the nodes of `scene`, which has its mesh, and the paths of groups that have one; of a scene whose handles a
  // recording has brought, the text must name the same nodes and moves none.
  HandlesReader(const JsonNode& node, const std::string& folder, Scene* scene);

  // Puts the initial positions of `scene` on the paths of groups.
  void PutOnPaths(Scene* scene) const;
  // Once obstacles are there: joins the paths of groups, those that something takes along among them, and clamps.
  void Attach(Scene* scene);

 private:
  struct Group {
    JsonNode node;
    std::vector<int> nodes;
    HandlePath path;                        // empty: it stays, or something takes it along
    std::shared_ptr<const RigidPath> body;  // what takes it along
    std::optional<JsonNode> attach, clamp;
  };

  void ReadGroup(const JsonNode& node, const std::string& folder, int num_nodes, std::set<int>* seen);
  static std::shared_ptr<const RigidPath> BodyOf(const Group& group, const Scene& scene);

  std::vector<Group> groups_;
  bool is_recorded_;
};

}  // namespace clothid

#endif  // CLOTHID_SIM_SCENE_HANDLES_JSON_H_
