# SPDX-License-Identifier: GPL-3.0-or-later
# What Debian's policy asks of a package beyond the files that are installed: compressed manuals, a changelog and a copyright.
# CPack runs it when the files of all packages are in folders, and before any is packed.
find_program(gzip gzip REQUIRED)
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC) # or SOURCE_DATE_EPOCH

foreach(component IN ITEMS program development)
  string(TOUPPER "CPACK_DEBIAN_${component}_PACKAGE_NAME" name)
  set(package "${${name}}")
  set(share "${CPACK_TEMPORARY_INSTALL_DIRECTORY}/${component}${CPACK_PACKAGING_INSTALL_PREFIX}/share")
  set(doc "${share}/doc/${package}")
  configure_file("${CMAKE_CURRENT_LIST_DIR}/copyright" "${doc}/copyright" COPYONLY)
  file(WRITE "${doc}/changelog"
"signorini (${CPACK_PACKAGE_VERSION}) unstable; urgency=medium

  * Version ${CPACK_PACKAGE_VERSION}. The repository's log tells of each change.

 -- ${CPACK_PACKAGE_CONTACT}  ${date}
")
  file(GLOB compressed "${doc}/changelog" "${share}/man/man*/*.[1-9]")
  execute_process(COMMAND "${gzip}" -9nf ${compressed} COMMAND_ERROR_IS_FATAL ANY)
  file(GLOB files "${doc}/*" "${share}/man/man*/*")
  file(CHMOD ${files} FILE_PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
endforeach()
