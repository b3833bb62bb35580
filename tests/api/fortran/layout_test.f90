!> The argument structs and constants of insitu_c.f90 are those of insitu.h, member by member.
program layout_test
  use, intrinsic :: iso_c_binding, only: c_int, c_int64_t, c_intptr_t, c_loc, c_ptr, c_sizeof
  use, intrinsic :: iso_fortran_env, only: error_unit, int64
  use insitu_c
  implicit none

  interface
    function layout_of(which, numbers) bind(c) result(count)
      import :: c_int, c_int64_t
      integer(c_int), value :: which
      integer(c_int64_t), intent(out) :: numbers(*)
      integer(c_int) :: count
    end function layout_of
    function constants(numbers) bind(c) result(count)
      import :: c_int, c_int64_t
      integer(c_int64_t), intent(out) :: numbers(*)
      integer(c_int) :: count
    end function constants
  end interface

  type(c_session_options), target :: options
  type(c_array), target :: array
  type(c_cells), target :: cells
  type(c_block), target :: block
  type(c_faces), target :: faces
  type(c_frame), target :: frame
  type(insitu_commit_report), target :: commit
  type(insitu_validation), target :: validation
  type(c_audit_entry), target :: audit
  type(c_locate_args), target :: locate
  type(c_sample_args), target :: sample
  type(c_vertices_args), target :: vertices
  type(insitu_report), target :: report
  type(c_locator), target :: locator
  type(c_locator_info), target :: info
  type(c_amr), target :: amr
  type(c_patch), target :: patch
  type(c_leaves), target :: leaves
  type(insitu_amr_info), target :: amr_info
  type(c_probe_answers), target :: answers
  integer :: failures = 0

  call compare('options', 0, c_sizeof(options), [ &
      c_loc(options%size), c_loc(options%scene), c_loc(options%scene_text), c_loc(options%output), &
      c_loc(options%default_scene), c_loc(options%threads), c_loc(options%strict), &
      c_loc(options%log_level), c_loc(options%log), c_loc(options%log_user), &
      c_loc(options%communicator), c_loc(options%fortran_communicator), c_loc(options%preview)])
  call compare('array', 1, c_sizeof(array), [ &
      c_loc(array%size), c_loc(array%data), c_loc(array%type), c_loc(array%components), &
      c_loc(array%count), c_loc(array%extent), c_loc(array%stride), &
      c_loc(array%component_stride), c_loc(array%memory), c_loc(array%converted), &
      c_loc(array%indirect), c_loc(array%offset)])
  call compare('cells', 2, c_sizeof(cells), [ &
      c_loc(cells%size), c_loc(cells%layout), c_loc(cells%shape), c_loc(cells%count), &
      c_loc(cells%connectivity), c_loc(cells%types), c_loc(cells%offsets), &
      c_loc(cells%index_base)])
  call compare('faces', 17, c_sizeof(faces), [ &
      c_loc(faces%size), c_loc(faces%form), c_loc(faces%index_base), c_loc(faces%cell_count), &
      c_loc(faces%face_count), c_loc(faces%vertices), c_loc(faces%offsets), c_loc(faces%owner), &
      c_loc(faces%neighbour), c_loc(faces%boundary_count), c_loc(faces%boundary_vertices), &
      c_loc(faces%boundary_offsets), c_loc(faces%boundary_owner), c_loc(faces%far_cells), &
      c_loc(faces%cell_faces), c_loc(faces%cell_offsets)])
  call compare('block', 3, c_sizeof(block), [ &
      c_loc(block%size), c_loc(block%kind), c_loc(block%vertices), c_loc(block%origin), &
      c_loc(block%spacing), c_loc(block%coordinates), c_loc(block%first), c_loc(block%dimensions)])
  call compare('frame', 4, c_sizeof(frame), [ &
      c_loc(frame%size), c_loc(frame%kind), c_loc(frame%origin), c_loc(frame%utm_zone), &
      c_loc(frame%utm_north), c_loc(frame%angle), c_loc(frame%length), c_loc(frame%vertical)])
  call compare('commit', 5, c_sizeof(commit), [ &
      c_loc(commit%size), c_loc(commit%action), c_loc(commit%validated), c_loc(commit%seconds), &
      c_loc(commit%cells), c_loc(commit%vertices), c_loc(commit%bytes), &
      c_loc(commit%bytes_allocated), c_loc(commit%cost_ratio), c_loc(commit%builder)])
  call compare('validation', 6, c_sizeof(validation), [ &
      c_loc(validation%size), c_loc(validation%cells), c_loc(validation%index_errors), &
      c_loc(validation%shape_errors), c_loc(validation%coordinate_errors), &
      c_loc(validation%inverted_cells), c_loc(validation%zero_volume_cells), &
      c_loc(validation%folded_cells), c_loc(validation%collapsed_cells), &
      c_loc(validation%ghost_cells), c_loc(validation%coincident_vertices), &
      c_loc(validation%crowded_faces), c_loc(validation%split_faces), &
      c_loc(validation%hanging_vertices), c_loc(validation%covered_vertices)])
  call compare('audit', 7, c_sizeof(audit), [ &
      c_loc(audit%size), c_loc(audit%name), c_loc(audit%data), c_loc(audit%bytes), &
      c_loc(audit%borrowed), c_loc(audit%reason)])
  call compare('locate', 8, c_sizeof(locate), [ &
      c_loc(locate%size), c_loc(locate%points), c_loc(locate%point_arrays), c_loc(locate%frame), &
      c_loc(locate%accuracy), c_loc(locate%cell_base), c_loc(locate%cells), &
      c_loc(locate%pieces), c_loc(locate%parametric), c_loc(locate%found), c_loc(locate%reasons), &
      c_loc(locate%memory), c_loc(locate%stream), c_loc(locate%scope), c_loc(locate%ranks), &
      c_loc(locate%global_cells), c_loc(locate%outside), c_loc(locate%greatest_distance), &
      c_loc(locate%distances), c_loc(locate%nearest)])
  call compare('sample', 9, c_sizeof(sample), [ &
      c_loc(sample%size), c_loc(sample%locate), c_loc(sample%fields), c_loc(sample%field_count), &
      c_loc(sample%values)])
  call compare('answers', 19, c_sizeof(answers), [ &
      c_loc(answers%size), c_loc(answers%name), c_loc(answers%cycle), c_loc(answers%time), &
      c_loc(answers%answered), c_loc(answers%column_count), c_loc(answers%point_count), &
      c_loc(answers%column_names), c_loc(answers%points), c_loc(answers%inside), &
      c_loc(answers%values)])
  call compare('vertices', 18, c_sizeof(vertices), [ &
      c_loc(vertices%size), c_loc(vertices%points), c_loc(vertices%point_arrays), &
      c_loc(vertices%nearest), c_loc(vertices%frame), c_loc(vertices%greatest_distance), &
      c_loc(vertices%scope), c_loc(vertices%vertex_base), c_loc(vertices%vertices), &
      c_loc(vertices%pieces), c_loc(vertices%ranks), c_loc(vertices%global_vertices), &
      c_loc(vertices%distances), c_loc(vertices%places)])
  call compare('report', 10, c_sizeof(report), [ &
      c_loc(report%size), c_loc(report%executions), c_loc(report%commit_s), &
      c_loc(report%query_s), c_loc(report%advect_s), c_loc(report%render_s), &
      c_loc(report%output_s), c_loc(report%keeps), c_loc(report%refits), c_loc(report%rebuilds), &
      c_loc(report%bytes_borrowed), c_loc(report%bytes_held), c_loc(report%bytes_peak), &
      c_loc(report%bytes_by_purpose), c_loc(report%points_located), &
      c_loc(report%points_outside), c_loc(report%particles_seeded), c_loc(report%particles), &
      c_loc(report%frames), c_loc(report%probe_rows), c_loc(report%files), &
      c_loc(report%failures), c_loc(report%located_by_reason), c_loc(report%ranges_s), &
      c_loc(report%classify_s), c_loc(report%purposes), c_loc(report%endings), &
      c_loc(report%reasons), c_loc(report%halo_cells), c_loc(report%messages_sent), &
      c_loc(report%bytes_sent)])
  call compare('locator', 11, c_sizeof(locator), [ &
      c_loc(locator%size), c_loc(locator%method), c_loc(locator%backend)])
  call compare('locator_info', 12, c_sizeof(info), [ &
      c_loc(info%size), c_loc(info%method), c_loc(info%backend), c_loc(info%reason), &
      c_loc(info%primitives), c_loc(info%bytes), c_loc(info%bytes_peak), &
      c_loc(info%bytes_copied), c_loc(info%kept), c_loc(info%by_neighbour), c_loc(info%by_tree), &
      c_loc(info%settled_on_host)])
  call compare('amr', 13, c_sizeof(amr), [ &
      c_loc(amr%size), c_loc(amr%origin), c_loc(amr%spacing), c_loc(amr%level_count), &
      c_loc(amr%ratios), c_loc(amr%finest_first), c_loc(amr%reconstruction), &
      c_loc(amr%dimensions), c_loc(amr%reserved)])
  call compare('patch', 14, c_sizeof(patch), [ &
      c_loc(patch%size), c_loc(patch%level), c_loc(patch%lower), c_loc(patch%cells), &
      c_loc(patch%ghosts_before), c_loc(patch%ghosts_after)])
  call compare('leaves', 15, c_sizeof(leaves), [ &
      c_loc(leaves%size), c_loc(leaves%levels), c_loc(leaves%corners), &
      c_loc(leaves%corner_bits), c_loc(leaves%offset)])
  call compare('amr info', 16, c_sizeof(amr_info), [ &
      c_loc(amr_info%size), c_loc(amr_info%leaves), c_loc(amr_info%masked), &
      c_loc(amr_info%gridlets), c_loc(amr_info%cubes), c_loc(amr_info%stitching), &
      c_loc(amr_info%folded), c_loc(amr_info%repaired), c_loc(amr_info%bytes), &
      c_loc(amr_info%build_s), c_loc(amr_info%by_places)])
  call compare_constants()
  if (failures > 0) error stop 1

contains

  subroutine compare(what, which, size_here, members)
    character(len=*), intent(in) :: what
    integer, intent(in) :: which
    integer(int64), intent(in) :: size_here
    type(c_ptr), intent(in) :: members(:)
    integer(c_int64_t) :: there(40), here
    character(len=24) :: member
    integer :: count, i

    count = layout_of(int(which, c_int), there)
    if (count /= size(members) + 1) then
      failures = failures + 1
      write (error_unit, '(2a, i0, a, i0)') what, ': members in C ', count - 1, ', here ', size(members)
      return
    end if
    call expect_equal(what, 'size', size_here, there(1))
    do i = 1, size(members)
      here = transfer(members(i), 0_c_intptr_t) - transfer(members(1), 0_c_intptr_t)
      write (member, '(a, i0)') 'offset of member ', i
      call expect_equal(what, trim(member), here, there(i + 1))
    end do
  end subroutine compare

  subroutine expect_equal(struct, what, here, there)
    character(len=*), intent(in) :: struct, what
    integer(c_int64_t), intent(in) :: here, there
    if (here == there) return
    failures = failures + 1
    write (error_unit, '(4a, 2(i0, a))') struct, ', ', what, ': ', there, ' in C, ', here, ' here'
  end subroutine expect_equal

  subroutine compare_constants()
    integer(c_int64_t) :: there(200)
    integer :: count

    associate (here => [ &
        insitu_memory_room, insitu_end_room, insitu_reason_room, &
        insitu_ok, insitu_error_argument, insitu_error_handle, insitu_error_busy, &
        insitu_error_order, insitu_error_mesh, insitu_error_field, insitu_error_scene, &
        insitu_error_file, insitu_error_memory, insitu_error_unsupported, &
        insitu_error_conversion, insitu_error_action, insitu_error_internal, insitu_float32, &
        insitu_float64, insitu_int32, insitu_int64, insitu_uint8, insitu_host, insitu_device, &
        insitu_vertex, insitu_cell, insitu_triangle, insitu_pixel, insitu_quad, &
        insitu_tetrahedron, insitu_voxel, insitu_hexahedron, &
        insitu_wedge, insitu_pyramid, insitu_fast, insitu_standard, insitu_exact, &
        insitu_method_auto, insitu_method_bvh, insitu_method_user_geometry, &
        insitu_method_replicated_faces, insitu_method_shared_faces, &
        insitu_method_shared_bilinear_faces, insitu_backend_auto, insitu_backend_cpu, &
        insitu_backend_cuda, insitu_backend_optix, &
        insitu_nothing, insitu_fields, insitu_geometry, insitu_topology, insitu_all, &
        insitu_log_error, insitu_log_warning, insitu_log_info, insitu_log_debug, &
        insitu_no_communicator, &
        insitu_layout_uniform, insitu_layout_mixed, insitu_layout_padded, insitu_block_uniform, &
        insitu_block_rectilinear, insitu_block_curvilinear, insitu_ghosts_vtk, &
        insitu_ghosts_ascent, insitu_outside_none, insitu_outside_nearest, insitu_dual, insitu_nearest, insitu_frame_cartesian, &
        insitu_frame_geocentric, &
        insitu_frame_geodetic, insitu_frame_enu, insitu_frame_utm, insitu_degrees, &
        insitu_radians, insitu_metres, insitu_kilometres, insitu_up, insitu_down, &
        insitu_keep, insitu_refit, &
        insitu_rebuild, insitu_builder_none, insitu_builder_morton, insitu_builder_surface_area, &
        insitu_reason_outside, insitu_reason_certified, insitu_reason_exact, &
        insitu_reason_on_face, insitu_reason_on_edge, insitu_reason_on_vertex, &
        insitu_reason_count, insitu_end_alive, insitu_end_left, insitu_end_stagnated, &
        insitu_end_expired, insitu_end_step_limit, insitu_end_seed_outside, &
        insitu_end_not_finite, insitu_end_killed, insitu_end_stopped, insitu_end_removed, &
        insitu_end_step_too_small, insitu_end_hole, insitu_end_hidden, insitu_end_blank, &
        insitu_end_partition, insitu_end_count, insitu_memory_tree, &
        insitu_memory_build, insitu_memory_ranges, insitu_memory_earlier, insitu_memory_query, &
        insitu_memory_tracer, insitu_memory_frame, insitu_memory_converted, &
        insitu_memory_embree, insitu_memory_device, insitu_memory_amr, insitu_memory_gathered, &
        insitu_memory_geocentric, insitu_memory_chart, insitu_memory_neighbours, &
        insitu_memory_blank, insitu_memory_halo, insitu_memory_polyhedra, insitu_memory_flat, &
        insitu_memory_held, insitu_memory_count, &
        insitu_faces_owners, insitu_faces_cells])
      count = constants(there)
      if (count == size(here)) then
        if (all(there(:count) == here)) return
      end if
    end associate
    failures = failures + 1
    write (error_unit, '(a)') 'constants differ from insitu.h'
  end subroutine compare_constants

end program layout_test
