// Cards of a cloth, and the scenes that they are put into.
#include "datasets/fabric/fabric_card.h"
#include "datasets/fabric/scene_with_fabric.h"
#include "sim/scene/scene_json.h"
#include "tests/fuzz/fuzz_target.h"

int clothid::FuzzFabricCard(const std::uint8_t* data, std::size_t size) {
  static const MemoryFile file;
  file.Write(AsText(data, size));
  FabricCard card;
  if (!Accepts([&] { card = ReadFabricCard(file.path()); }, file.path())) return 0;
  file.Write(FabricCardJson(card));
  FabricCard again;
  Check(Accepts([&] { again = ReadFabricCard(file.path()); }, file.path()), "a card that reads back");
  Check(FabricCardJson(again) == FabricCardJson(card), "the same card");
  for (const char* materials : {"", ", \"materials\": {\"k_stretch\": 80, \"k_bend\": 1e-4}"}) {
    const std::string scene = std::string(
                                  "{\"clothid_scene\": 2, \"duration\": 0.1, \"mesh\": {\"grid\": {\"nodes\": "
                                  "[2, 2], \"size\": [1, 1]}}") +
                              materials + "}";
    Accepts([&] { ParseScene(WithFabricCard(scene, card, "scene"), "scene", ""); }, "scene");
  }
  return 0;
}
