# SPDX-License-Identifier: GPL-3.0-or-later
"""All bad inputs, theme by theme."""

from case import Case
from drop_cases import drop_cases
from field_cases import effect_cases, expression_cases, material_cases, time_series_cases
from fit_cases import fit_cases
from folder_cases import desired_run_cases, first_guess_cases, folder_cases
from friction_cases import friction_cases
from mesh_cases import mesh_content_cases, mesh_file_cases, space_cases
from model_cases import model_cases
from obstacle_cases import obstacle_cases
from option_cases import method_cases, option_cases
from parts_cases import parts_cases
from relaxation_cases import relaxation_cases
from rigid_body_cases import rigid_body_cases
from scenario_cases import scenario_cases
from scene_cases import key_cases, scene_file_cases, type_cases
from surroundings_cases import surroundings_cases
from value_cases import dimension_cases, probe_cases, range_cases


def all_cases() -> list[Case]:
    """Every case."""
    return [
        *scene_file_cases(),
        *key_cases(),
        *type_cases(),
        *range_cases(),
        *probe_cases(),
        *fit_cases(),
        *scenario_cases(),
        *dimension_cases(),
        *obstacle_cases(),
        *friction_cases(),
        *rigid_body_cases(),
        *drop_cases(),
        *parts_cases(),
        *expression_cases(),
        *time_series_cases(),
        *effect_cases(),
        *surroundings_cases(),
        *relaxation_cases(),
        *method_cases(),
        *material_cases(),
        *option_cases(),
        *mesh_file_cases(),
        *mesh_content_cases(),
        *space_cases(),
        *model_cases(),
        *desired_run_cases(),
        *first_guess_cases(),
        *folder_cases(),
    ]
