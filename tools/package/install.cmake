# Where libraries and programs go on installation, and how they find each other there: relative to themselves.
# What is installed is of the package clothid, unless it says that it is of another.
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME clothid)
set(clothid_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/clothid)
set(clothid_program_dir ${CMAKE_INSTALL_LIBEXECDIR}/clothid)
file(RELATIVE_PATH clothid_libraries_from_programs /${clothid_program_dir} /${CMAKE_INSTALL_LIBDIR})

# clothid_install_library(<folder> <public header>...): the library clothid::<folder>, for `find_package(clothid)`, with
# its headers in their rooms and <folder>/<folder>.h, which includes all of them. Headers that are not public stay out, so
# that their contents may change from one version to the next.
function(clothid_install_library name)
  set_target_properties(clothid_${name} PROPERTIES
    EXPORT_NAME ${name}
    VERSION ${PROJECT_VERSION}
    # While the major version is 0, a minor version may change the interface.
    SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
    INSTALL_RPATH $ORIGIN)
  install(TARGETS clothid_${name} EXPORT clothid_${name})
  set(include_dir ${CMAKE_INSTALL_INCLUDEDIR}/clothid/${name})
  set(generated_dir ${CMAKE_CURRENT_BINARY_DIR}/include)
  set(umbrella "// Everything public of clothid::${name}.\n#pragma once\n")
  foreach(header IN LISTS ARGN)
    get_filename_component(room ${header} DIRECTORY)
    install(FILES ${header} DESTINATION ${include_dir}/${room})
    string(APPEND umbrella "#include \"${name}/${header}\"\n")
    if(room)
      # Version 0.1 had it without its room.
      get_filename_component(file ${header} NAME)
      file(CONFIGURE OUTPUT ${generated_dir}/${file} CONTENT "#pragma once\n#include \"${name}/${header}\"\n")
      install(FILES ${generated_dir}/${file} DESTINATION ${include_dir})
    endif()
  endforeach()
  file(CONFIGURE OUTPUT ${generated_dir}/${name}.h CONTENT "${umbrella}")
  install(FILES ${generated_dir}/${name}.h DESTINATION ${include_dir})
  list(TRANSFORM ARGN PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ OUTPUT_VARIABLE headers)
  set_property(GLOBAL APPEND PROPERTY CLOTHID_PUBLIC_HEADERS ${headers})
  install(EXPORT clothid_${name} NAMESPACE clothid:: DESTINATION ${clothid_package_dir})
endfunction()

# clothid_install_program(<name>): the command `clothid <name>`.
function(clothid_install_program name)
  set_target_properties(${name} PROPERTIES INSTALL_RPATH $ORIGIN/${clothid_libraries_from_programs})
  install(TARGETS ${name} DESTINATION ${clothid_program_dir})
endfunction()
