# clothid_embed(<target> <function> <file>): adds `std::string_view clothid::<function>()` to the target: the bytes of
# the file when the target is built. Declare it where it is used.
function(clothid_embed target function file)
  get_filename_component(path ${file} ABSOLUTE)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${function}.cc)
  configure_file(${PROJECT_SOURCE_DIR}/identify/embedded_file.cc.in ${source} @ONLY)
  set_source_files_properties(${source} PROPERTIES OBJECT_DEPENDS ${path})
  target_sources(${target} PRIVATE ${source})
endfunction()
